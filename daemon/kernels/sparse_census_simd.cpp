// sparse_census_simd.cpp: sparse census codes for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/sparse_census_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void sparse_census(View8 image, int first, int last, Plane<uint8_t> low, Plane<uint8_t> high) {
  plain::sparse_census(image, first, last, low, high);
}
#else

constexpr int reach = 4;  // columns to either side

/// Bit `bit` where what `offset` leads to is darker than what stands opposite.
template <int bit, class D>
HWY_INLINE hn::Vec<D> darker(D d, const uint8_t* below, const uint8_t* above, int offset) {
  const auto there = hn::LoadU(d, below + offset), opposite = hn::LoadU(d, above - offset);
  return hn::IfThenElseZero(hn::Lt(there, opposite), hn::Set(d, uint8_t{1 << bit}));
}

/// `rows` are those from 3 above the centre to 3 below it; the same pairs, in the same order, as in the plain form.
template <class D>
HWY_INLINE void codes(D d, const uint8_t* const* rows, int x, uint8_t* low, uint8_t* high) {
  const uint8_t *a = rows[3] + x, *up1 = rows[2] + x, *up2 = rows[1] + x, *up3 = rows[0] + x;
  const uint8_t *down1 = rows[4] + x, *down2 = rows[5] + x, *down3 = rows[6] + x;
  auto code = hn::Or(darker<0>(d, a, a, 1), darker<1>(d, a, a, 2));
  code = hn::Or(code, hn::Or(darker<2>(d, a, a, 3), darker<3>(d, a, a, 4)));
  code = hn::Or(code, hn::Or(darker<4>(d, down1, up1, -2), darker<5>(d, down1, up1, 0)));
  code = hn::Or(code, hn::Or(darker<6>(d, down1, up1, 2), darker<7>(d, down1, up1, -3)));
  hn::StoreU(code, d, low + x);
  code = hn::Or(darker<0>(d, down1, up1, 3), darker<1>(d, down2, up2, -1));
  code = hn::Or(code, hn::Or(darker<2>(d, down2, up2, 1), darker<3>(d, down2, up2, 0)));
  code = hn::Or(code, hn::Or(darker<4>(d, down2, up2, -3), darker<5>(d, down2, up2, 3)));
  code = hn::Or(code, hn::Or(darker<6>(d, down3, up3, -1), darker<7>(d, down3, up3, 1)));
  hn::StoreU(code, d, high + x);
}

/// A row by one width of vector: false where the image is too narrow for it.
template <class D>
HWY_INLINE bool row_of(D d, const uint8_t* const* rows, int width, uint8_t* low, uint8_t* high) {
  const int lanes = static_cast<int>(hn::Lanes(d)), end = width - reach - lanes;
  if (end < reach) return false;
  for (int x = reach; x < end; x += lanes) codes(d, rows, x, low, high);
  codes(d, rows, end, low, high);
  return true;
}

void sparse_census(View8 image, int first, int last, Plane<uint8_t> low, Plane<uint8_t> high) {
  const hn::CappedTag<uint8_t, 64> d;
  const hn::CappedTag<uint8_t, 16> d16;
  const int width = image.width;
  for (int y = first; y < last; ++y) {
    const uint8_t* rows[7];
    for (int k = 0; k < 7; ++k) rows[k] = image.row(std::clamp(y + k - 3, 0, image.height - 1));
    if (!row_of(d, rows, width, low.row(y), high.row(y)) && !row_of(d16, rows, width, low.row(y), high.row(y))) {
      plain::sparse_census(image, y, y + 1, low, high);
      continue;
    }
    // The columns at the sides look beyond the image.
    for (int from : {0, width - reach}) {
      uint8_t side[7][3 * reach], out[2][3 * reach];
      const uint8_t* sides[7];
      for (int k = 0; k < 7; ++k) {
        for (int j = 0; j < 3 * reach; ++j) side[k][j] = rows[k][std::clamp(from - reach + j, 0, width - 1)];
        sides[k] = side[k];
      }
      const hn::CappedTag<uint8_t, reach> d4;
      for (int j = reach; j < 2 * reach; j += static_cast<int>(hn::Lanes(d4))) codes(d4, sides, j, out[0], out[1]);
      std::copy_n(out[0] + reach, reach, low.row(y) + from);
      std::copy_n(out[1] + reach, reach, high.row(y) + from);
    }
  }
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(sparse_census);
void choose_sparse_census(Kernels& table) { table.sparse_census = VDISP_CHOSEN(sparse_census); }
}  // namespace vdisp::kernels
#endif
