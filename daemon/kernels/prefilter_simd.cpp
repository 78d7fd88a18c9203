// prefilter_simd.cpp: the pre-filters for all instruction sets: this file is compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/prefilter_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void x_sobel(View8 in, int cap, int first, int last, Plane<uint8_t> out) { plain::x_sobel(in, cap, first, last, out); }
#else

/// Columns [x, x + lanes) of one row.
template <class D16>
HWY_INLINE void sobel_step(D16 d16, const uint8_t* above, const uint8_t* here, const uint8_t* below, int x, int cap, uint8_t* to) {
  const hn::Rebind<uint8_t, D16> d8;
  const auto load = [&](const uint8_t* row, int at) { return hn::PromoteTo(d16, hn::LoadU(d8, row + at)); };
  const auto middle = hn::Sub(load(here, x + 1), load(here, x - 1));
  auto gradient = hn::Add(hn::Add(middle, middle), hn::Sub(load(above, x + 1), load(above, x - 1)));
  gradient = hn::Add(gradient, hn::Sub(load(below, x + 1), load(below, x - 1)));
  const auto most = hn::Set(d16, static_cast<int16_t>(cap)), least = hn::Set(d16, static_cast<int16_t>(-cap));
  gradient = hn::Add(hn::Min(hn::Max(gradient, least), most), most);
  hn::StoreU(hn::DemoteTo(d8, gradient), d8, to + x);
}

void x_sobel(View8 in, int cap, int first, int last, Plane<uint8_t> out) {
  const hn::ScalableTag<int16_t> d16;
  const hn::CappedTag<int16_t, 1> one;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  for (int y = first; y < last; ++y) {
    const int border = in.height > 1 ? 1 : 0;
    const uint8_t* above = in.row(y > 0 ? y - 1 : border);
    const uint8_t* here = in.row(y);
    const uint8_t* below = in.row(y + 1 < in.height ? y + 1 : in.height - 1 - border);
    uint8_t* to = out.row(y);
    to[0] = to[in.width - 1] = static_cast<uint8_t>(cap);
    int x = 1;
    // The last full step is moved back onto the end of the row: what it writes twice is the same.
    if (in.width - 2 >= lanes) {
      for (; x + lanes <= in.width - 1; x += lanes) sobel_step(d16, above, here, below, x, cap, to);
      if (x < in.width - 1) sobel_step(d16, above, here, below, in.width - 1 - lanes, cap, to);
    } else {
      for (; x < in.width - 1; ++x) sobel_step(one, above, here, below, x, cap, to);
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
HWY_EXPORT(x_sobel);
void choose_prefilter(Kernels& table) { table.x_sobel = VDISP_CHOSEN(x_sobel); }
}  // namespace vdisp::kernels
#endif
