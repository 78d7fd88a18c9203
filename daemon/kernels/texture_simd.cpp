// texture_simd.cpp: the texture measure for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/texture_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void texture_row(View8 gradient, int zero, int window, int row, bool fresh, uint16_t* columns, uint16_t* out) {
  plain::texture_row(gradient, zero, window, row, fresh, columns, out);
}
#else

/// One row of the gradient taken into the sums of the columns, or out of them.
template <bool add, class D16>
HWY_INLINE void take_row(D16 d16, const uint8_t* gradient, int width, int zero, uint16_t* columns) {
  const hn::Rebind<uint8_t, D16> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto none = hn::Set(d8, static_cast<uint8_t>(zero));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto g = hn::LoadU(d8, gradient + x);
    const auto strength = hn::PromoteTo(d16, hn::Or(hn::SaturatedSub(g, none), hn::SaturatedSub(none, g)));
    const auto sum = hn::LoadU(d16, columns + x);
    hn::StoreU(add ? hn::Add(sum, strength) : hn::Sub(sum, strength), d16, columns + x);
  }
  for (; x < width; ++x) {
    const int strength = gradient[x] > zero ? gradient[x] - zero : zero - gradient[x];
    columns[x] = static_cast<uint16_t>(add ? columns[x] + strength : columns[x] - strength);
  }
}

void texture_row(View8 gradient, int zero, int window, int row, bool fresh, uint16_t* columns, uint16_t* out) {
  const hn::CappedTag<uint16_t, 32> d16;
  const int lanes = static_cast<int>(hn::Lanes(d16)), r = window / 2, width = gradient.width;
  if (fresh) {
    for (int x = 0; x < width + texture_margin; ++x) columns[x] = 0;
    for (int y = row - r; y <= row + r; ++y) take_row<true>(d16, gradient.row(y), width, zero, columns);
  } else {
    take_row<true>(d16, gradient.row(row + r), width, zero, columns);
    take_row<false>(d16, gradient.row(row - r - 1), width, zero, columns);
  }
  for (int x = 0; x < width - 2 * r; x += lanes) {
    auto sum = hn::LoadU(d16, columns + x), other = hn::Zero(d16);
    for (int i = 1; i < window; i += 2) {
      sum = hn::Add(sum, hn::LoadU(d16, columns + x + i));
      other = hn::Add(other, hn::LoadU(d16, columns + x + i + 1));
    }
    hn::StoreU(hn::Add(sum, other), d16, out + x + r);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(texture_row);
void choose_texture(Kernels& table) { table.texture_row = VDISP_CHOSEN(texture_row); }
}  // namespace vdisp::kernels
#endif
