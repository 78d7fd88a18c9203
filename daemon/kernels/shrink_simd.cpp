// shrink_simd.cpp: averaging areas for all instruction sets: halves, as cameras of 640 columns need; other factors are plain.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/shrink_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void shrink(View8 in, int factor, int first, int last, Plane<uint8_t> out) { plain::shrink(in, factor, first, last, out); }
#else

void shrink(View8 in, int factor, int first, int last, Plane<uint8_t> out) {
  const hn::ScalableTag<uint16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  if (factor != 2 || out.width < lanes) return plain::shrink(in, factor, first, last, out);
  const auto low = hn::Set(d16, uint16_t{255}), two = hn::Set(d16, uint16_t{2});
  for (int y = first; y < last; ++y) {
    const uint8_t *above = in.row(2 * y), *below = in.row(2 * y + 1);
    uint8_t* to = out.row(y);
    const auto body = [&](int x) HWY_ATTR {
      // Two pixels are a lane.
      const hn::Repartition<uint8_t, decltype(d16)> pairs;
      const auto a = hn::BitCast(d16, hn::LoadU(pairs, above + 2 * x)), b = hn::BitCast(d16, hn::LoadU(pairs, below + 2 * x));
      const auto upper = hn::Add(hn::And(a, low), hn::ShiftRight<8>(a)), lower = hn::Add(hn::And(b, low), hn::ShiftRight<8>(b));
      hn::StoreU(hn::TruncateTo(d8, hn::ShiftRight<2>(hn::Add(hn::Add(upper, lower), two))), d8, to + x);
    };
    int x = 0;
    for (; x + lanes <= out.width; x += lanes) body(x);
    if (x < out.width) body(out.width - lanes);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(shrink);
void choose_shrink(Kernels& table) { table.shrink = VDISP_CHOSEN(shrink); }
}  // namespace vdisp::kernels
#endif
