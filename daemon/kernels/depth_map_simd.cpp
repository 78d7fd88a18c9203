// depth_map_simd.cpp: counting by column for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/depth_map_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void count_depth(Plane<const int16_t> disparity, Plane<int16_t> counts, uint8_t* scratch) {
  plain::count_depth(disparity, counts, scratch);
}
#else

constexpr int together = 8;     // disparities counted in one pass over a strip of columns
constexpr int most_wide = 64;   // rows of counts up to which looking at all of them is cheaper than going where a pixel points
constexpr int most_rows = 255;  // that a byte can count

/// Whole px, a byte each; 0: none.
void to_bytes(Plane<const int16_t> disparity, int disparities, uint8_t* bytes) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto end = hn::Set(d16, static_cast<int16_t>(disparities)), zero = hn::Zero(d16);
  for (int y = 0; y < disparity.height; ++y) {
    const int16_t* row = disparity.row(y);
    uint8_t* to = bytes + static_cast<ptrdiff_t>(y) * disparity.width;
    const auto put = [&](int x) HWY_ATTR {
      const auto d = hn::ShiftRight<4>(hn::LoadU(d16, row + x));
      const auto there = hn::And(hn::Gt(d, zero), hn::Lt(d, end));
      hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(there, d)), d8, to + x);
    };
    int x = 0;
    for (; x + lanes <= disparity.width; x += lanes) put(x);
    if (x < disparity.width) put(disparity.width - lanes);
  }
}

/// The columns from x on, one vector of them, for `together` disparities from `first` on.
template <class D8>
HWY_INLINE void count_strip(D8 d8, const uint8_t* bytes, int width, int height, int first, int x, Plane<int16_t> counts) {
  const hn::Repartition<uint16_t, D8> d16;
  const hn::RebindToSigned<decltype(d16)> signed16;
  const auto low = hn::Set(d16, uint16_t{255});
  for (int from = 0; from < height; from += most_rows) {
    const int to = std::min(from + most_rows, height);
    auto n0 = hn::Zero(d8), n1 = n0, n2 = n0, n3 = n0, n4 = n0, n5 = n0, n6 = n0, n7 = n0;
    const auto is = [&](int i) HWY_ATTR { return hn::Set(d8, static_cast<uint8_t>(first + i)); };
    const auto w0 = is(0), w1 = is(1), w2 = is(2), w3 = is(3), w4 = is(4), w5 = is(5), w6 = is(6), w7 = is(7);
    const uint8_t* at = bytes + static_cast<ptrdiff_t>(from) * width + x;
    for (int y = from; y < to; ++y, at += width) {
      const auto d = hn::LoadU(d8, at);
      const auto one_more = [&](auto& n, auto which) HWY_ATTR { n = hn::Sub(n, hn::VecFromMask(d8, hn::Eq(d, which))); };
      one_more(n0, w0), one_more(n1, w1), one_more(n2, w2), one_more(n3, w3);
      one_more(n4, w4), one_more(n5, w5), one_more(n6, w6), one_more(n7, w7);
    }
    const auto put = [&](int i, auto n) HWY_ATTR {
      int16_t* row = counts.row(first + i) + x;
      const auto words = hn::BitCast(d16, n);
      auto even = hn::BitCast(signed16, hn::And(words, low)), odd = hn::BitCast(signed16, hn::ShiftRight<8>(words));
      if (from > 0) {
        auto even_before = even, odd_before = odd;
        hn::LoadInterleaved2(signed16, row, even_before, odd_before);
        even = hn::SaturatedAdd(even, even_before);
        odd = hn::SaturatedAdd(odd, odd_before);
      }
      hn::StoreInterleaved2(even, odd, signed16, row);
    };
    put(0, n0), put(1, n1), put(2, n2), put(3, n3), put(4, n4), put(5, n5), put(6, n6), put(7, n7);
  }
}

void count_depth(Plane<const int16_t> disparity, Plane<int16_t> counts, uint8_t* scratch) {
  const hn::ScalableTag<uint8_t> d8;
  const int lanes = static_cast<int>(hn::Lanes(d8)), width = disparity.width, disparities = counts.height;
  if (width < lanes || disparities > most_wide || disparities % together != 0) return plain::count_depth(disparity, counts, scratch);
  to_bytes(disparity, disparities, scratch);
  for (int x = 0; x < width; x += lanes) {
    const int at = std::min(x, width - lanes);
    for (int first = 0; first < disparities; first += together) count_strip(d8, scratch, width, disparity.height, first, at, counts);
  }
  std::fill_n(counts.row(0), width, int16_t{0});
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(count_depth);
void choose_depth_map(Kernels& table) { table.count_depth = VDISP_CHOSEN(count_depth); }
}  // namespace vdisp::kernels
#endif
