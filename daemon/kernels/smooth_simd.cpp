// smooth_simd.cpp: the smoothing for all instruction sets: compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/smooth_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void mean3x3(View8 in, int first, int last, Plane<uint8_t> out) { plain::mean3x3(in, first, last, out); }
void median3x3(View8 in, int first, int last, Plane<uint8_t> out) { plain::median3x3(in, first, last, out); }
#else

// Both work in two passes over a strip of a row: what the three pixels of a column give together, then what three columns give. The
// second pass reads the first one's columns at x - 1, x and x + 1, so that each column is worked out once.
constexpr int strip = 640;

/// Three rows of the image and where the result goes.
struct Rows {
  const uint8_t *above, *here, *below;
  uint8_t* to;
};

/// body(d, x) for steps of a full vector that cover [0, count), the last one moved back onto the end; for single ones where count is less.
template <class D, class Body>
HWY_INLINE void each_step(D d, int count, Body body) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (count < lanes) {
    for (int x = 0; x < count; ++x) body(hn::CappedTag<hn::TFromD<D>, 1>(), x);
    return;
  }
  int x = 0;
  for (; x + lanes <= count; x += lanes) body(d, x);
  if (x < count) body(d, count - lanes);
}

/// A column sum for each column from x - 1 to x + count.
struct Mean {
  using Value = uint16_t;
  static constexpr int planes = 1;
  template <class D>
  static HWY_INLINE void column(D d, const Rows& rows, int x, Value* to) {
    const hn::Rebind<uint8_t, D> d8;
    const auto load = [&](const uint8_t* row) { return hn::PromoteTo(d, hn::LoadU(d8, row + x)); };
    hn::StoreU(hn::Add(hn::Add(load(rows.above), load(rows.below)), load(rows.here)), d, to);
  }
  template <class D>
  static HWY_INLINE void across(D d, const Value* sums, uint8_t* to) {
    const hn::Rebind<uint8_t, D> d8;
    const hn::RebindToSigned<D> d16;
    const auto sum = hn::Add(hn::Add(hn::LoadU(d, sums), hn::LoadU(d, sums + 2)), hn::Add(hn::LoadU(d, sums + 1), hn::Set(d, 4)));
    // 7282 / 65536 is 1 / 9 and 0.000003 more: never a whole too many for sums up to 9 * 255 + 4.
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(d16, hn::MulHigh(sum, hn::Set(d, 7282)))), d8, to);
  }
};

/// The three pixels of a column in order.
struct Median {
  using Value = uint8_t;
  static constexpr int planes = 3;
  template <class D>
  static HWY_INLINE void column(D d, const Rows& rows, int x, Value* to) {
    const auto a = hn::LoadU(d, rows.above + x), b = hn::LoadU(d, rows.here + x), c = hn::LoadU(d, rows.below + x);
    const auto low = hn::Min(a, b), high = hn::Max(a, b), middle = hn::Min(high, c);
    hn::StoreU(hn::Min(low, middle), d, to);
    hn::StoreU(hn::Max(low, middle), d, to + plane);
    hn::StoreU(hn::Max(high, c), d, to + 2 * plane);
  }
  template <class D>
  static HWY_INLINE void across(D d, const Value* from, uint8_t* to) {
    const auto load = [&](int i) { return hn::LoadU(d, from + i); };
    const auto of_three = [](auto a, auto b, auto c) { return hn::Max(hn::Min(a, b), hn::Min(hn::Max(a, b), c)); };
    const auto least = hn::Max(hn::Max(load(0), load(1)), load(2));
    const auto middle = of_three(load(plane), load(plane + 1), load(plane + 2));
    const auto most = hn::Min(hn::Min(load(2 * plane), load(2 * plane + 1)), load(2 * plane + 2));
    hn::StoreU(of_three(least, middle, most), d, to);
  }
  static constexpr int plane = strip + 2;
};

template <class Kind>
HWY_INLINE void smooth(View8 in, int first, int last, Plane<uint8_t> out) {
  const hn::ScalableTag<typename Kind::Value> d;
  typename Kind::Value columns[Kind::planes * (strip + 2)];
  for (int y = first; y < last; ++y) {
    const Rows rows{in.row(std::max(y - 1, 0)), in.row(y), in.row(std::min(y + 1, in.height - 1)), out.row(y)};
    for (int from = 0; from < in.width; from += strip) {
      const int to = std::min(from + strip, in.width);
      // Columns [from - 1, to + 1), as far as there are such; place i holds column from - 1 + i.
      const int left = std::max(from - 1, 0), right = std::min(to + 1, in.width);
      each_step(d, right - left, [&](auto tag, int i) { Kind::column(tag, rows, left + i, columns + left - (from - 1) + i); });
      for (int p = 0; p < Kind::planes; ++p) {
        auto* plane = columns + p * (strip + 2);
        if (from == 0) plane[0] = plane[1];
        if (to == in.width) plane[to - from + 1] = plane[to - from];
      }
      each_step(d, to - from, [&](auto tag, int i) { Kind::across(tag, columns + i, rows.to + from + i); });
    }
  }
}

void mean3x3(View8 in, int first, int last, Plane<uint8_t> out) { smooth<Mean>(in, first, last, out); }
void median3x3(View8 in, int first, int last, Plane<uint8_t> out) { smooth<Median>(in, first, last, out); }

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(mean3x3);
HWY_EXPORT(median3x3);
void choose_smooth(Kernels& table) {
  table.mean3x3 = VDISP_CHOSEN(mean3x3);
  table.median3x3 = VDISP_CHOSEN(median3x3);
}
}  // namespace vdisp::kernels
#endif
