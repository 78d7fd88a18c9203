// debayer_simd.cpp: the de-Bayer filter for all instruction sets: even and odd columns apart, so that no pixel asks which it is.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/debayer_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void debayer(View8 in, Bayer pattern, int first, int last, Plane<uint8_t> out) { plain::debayer(in, pattern, first, last, out); }
#else

using Words = hn::ScalableTag<uint16_t>;
using Vec = hn::Vec<Words>;

/// Pairs of pixels from there on.
HWY_INLINE Vec pairs(const uint8_t* at) {
  const Words d;
  return hn::BitCast(d, hn::LoadU(hn::Repartition<uint8_t, Words>(), at));
}
HWY_INLINE Vec firsts(Vec pairs) { return hn::And(pairs, hn::Set(Words(), 255)); }
HWY_INLINE Vec seconds(Vec pairs) { return hn::ShiftRight<8>(pairs); }

/// From the colours in 1/128.
HWY_INLINE Vec luma(const BayerRow& row, Vec own, Vec green, Vec other) {
  const Words d;
  const hn::RebindToSigned<Words> ds;
  const auto weighted = [&](Vec colour, int16_t weight)
                            HWY_ATTR { return hn::MulFixedPoint15(hn::BitCast(ds, colour), hn::Set(ds, weight)); };
  const auto sum = hn::Add(hn::Add(weighted(own, row.own), weighted(green, row.green)), weighted(other, row.other));
  return hn::ShiftRight<7>(hn::Add(hn::BitCast(d, sum), hn::Set(d, 64)));
}

struct Rows {
  const uint8_t *above, *here, *below;
};

/// Pixels from x on, which is even, as many as a vector of bytes has.
template <bool colour_first>
HWY_INLINE void debayer_step(const BayerRow& row, const Rows& r, int x, uint8_t* to) {
  // Of each pair, the pixel that is red or blue, and the green one: on its right if the colour is first, else on its left.
  const auto colour_of = [](Vec both) HWY_ATTR { return colour_first ? firsts(both) : seconds(both); };
  const auto green_of = [](Vec both) HWY_ATTR { return colour_first ? seconds(both) : firsts(both); };
  // One pixel farther on, or one before: the green on the colour's other side, and the colour on the green's other side.
  constexpr int before = colour_first ? -1 : 1;
  const Vec here = pairs(r.here + x), above = pairs(r.above + x), below = pairs(r.below + x);
  const Vec colour = colour_of(here), green = green_of(here);
  const Vec green_beyond = colour_of(pairs(r.here + x + before)), colour_beyond = green_of(pairs(r.here + x - before));
  const Vec over_colour = hn::Add(colour_of(above), colour_of(below)), over_green = hn::Add(green_of(above), green_of(below));
  const Vec over_beyond = hn::Add(colour_of(pairs(r.above + x + before)), colour_of(pairs(r.below + x + before)));

  const Vec greens = hn::Add(hn::Add(green, green_beyond), over_colour);
  const Vec at_colour = luma(row, hn::ShiftLeft<7>(colour), hn::ShiftLeft<5>(greens), hn::ShiftLeft<5>(hn::Add(over_green, over_beyond)));
  const Vec at_green = luma(row, hn::ShiftLeft<6>(hn::Add(colour, colour_beyond)), hn::ShiftLeft<7>(green), hn::ShiftLeft<6>(over_green));
  const Vec both = colour_first ? hn::Or(at_colour, hn::ShiftLeft<8>(at_green)) : hn::Or(at_green, hn::ShiftLeft<8>(at_colour));
  const hn::Repartition<uint8_t, Words> d8;
  hn::StoreU(hn::BitCast(d8, both), d8, to + x);
}

/// Columns [2, n) for some n, which it returns, at most one less than the width.
template <bool colour_first>
HWY_NOINLINE int debayer_row(const BayerRow row, const Rows r, int width, uint8_t* to) {
  const int lanes = static_cast<int>(hn::Lanes(hn::Repartition<uint8_t, Words>()));
  int x = 2;
  if (x + lanes >= width) return x;
  for (; x + lanes < width; x += lanes) debayer_step<colour_first>(row, r, x, to);
  // The last step is moved back: what it writes twice is the same.
  const int end = (width - 1) & ~1;
  if (x < end) debayer_step<colour_first>(row, r, end - lanes, to);
  return end;
}

void debayer(View8 in, Bayer pattern, int first, int last, Plane<uint8_t> out) {
  for (int y = first; y < last; ++y) {
    const BayerRow row(pattern, y);
    const int border = in.height > 1 ? 1 : 0;
    const Rows r{in.row(y > 0 ? y - 1 : border), in.row(y), in.row(y + 1 < in.height ? y + 1 : in.height - 1 - border)};
    uint8_t* to = out.row(y);
    const int done = row.colour_first ? debayer_row<true>(row, r, in.width, to) : debayer_row<false>(row, r, in.width, to);
    for (int x = 0; x < std::min(2, in.width); ++x) to[x] = plain::debayered(in, row, x, y);
    for (int x = done; x < in.width; ++x) to[x] = plain::debayered(in, row, x, y);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(debayer);
void choose_debayer(Kernels& table) { table.debayer = VDISP_CHOSEN(debayer); }
}  // namespace vdisp::kernels
#endif
