// prefilter_simd.cpp: the pre-filters for all instruction sets: this file is compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

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
void log_filter(View8 in, int window, int cap, int first, int last, Plane<uint8_t> out) {
  plain::log_filter(in, window, cap, first, last, out);
}
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

// The Laplacian of a Gaussian is boxes of boxes: g is 1 2 3 2 1 of boxes of window - 6, h is 1 0 0 -2 0 0 1 of them. Down a strip of
// columns the boxes of seven rows are kept, each summed once; across, the boxes come last. All in 16 bits: sums may leave them on the way,
// the response does not: it stays below 28400.
constexpr int strip = 640, most_lanes = 64;

/// Each row begins window / 2 columns before the strip, and takes whole vectors at its end.
struct Strip {
  static constexpr int size = strip + 10 + most_lanes + 22;
  alignas(64) int16_t boxes[7][size];  // of row y at y modulo 7
  int16_t smooth[size], second[size], sums[size];
};

/// body(d, x) for steps of a full vector that cover [0, count), the last one moved back onto the end; for single ones where count is less.
template <class D, class Body>
HWY_INLINE void each_step(D d, int count, Body body) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (count < lanes) {
    for (int x = 0; x < count; ++x) body(hn::CappedTag<int16_t, 1>(), x);
    return;
  }
  int x = 0;
  for (; x + lanes <= count; x += lanes) body(d, x);
  if (x < count) body(d, count - lanes);
}

/// The boxes of row y for columns [from - window / 2, to + window / 2).
template <int window>
HWY_NOINLINE void sum_boxes(View8 in, int y, int from, int to, int16_t* boxes) {
  const hn::CappedTag<int16_t, most_lanes> d;
  constexpr int reach = window / 2, box = window - 6;
  const int origin = from - reach, left = std::max(origin, 0), right = std::min(to + reach, in.width);
  const uint8_t* rows[box];
  for (int k = 0; k < box; ++k) rows[k] = in.row(mirrored_at_border(y + k - box / 2, in.height)) + left;
  each_step(d, right - left, [&](auto tag, int i) {
    const hn::Rebind<uint8_t, decltype(tag)> d8;
    const auto load = [&](int k) { return hn::PromoteTo(tag, hn::LoadU(d8, rows[k] + i)); };
    auto sum = hn::Add(hn::Add(load(0), load(1)), load(2));
    if constexpr (box == 5) sum = hn::Add(sum, hn::Add(load(3), load(4)));
    hn::StoreU(sum, tag, boxes + left - origin + i);
  });
  for (int x = origin; x < left; ++x) boxes[x - origin] = boxes[mirrored_at_border(x, in.width) - origin];
  for (int x = right; x < to + reach; ++x) boxes[x - origin] = boxes[mirrored_at_border(x, in.width) - origin];
}

/// 1 2 3 2 1 of the loaded.
template <class Load>
HWY_INLINE auto bell(Load load) {
  const auto near = hn::Add(hn::Add(load(-1), load(1)), load(0));
  return hn::Add(hn::Add(near, near), hn::Add(hn::Add(load(-2), load(2)), load(0)));
}

/// 1 0 0 -2 0 0 1 of the loaded.
template <class Load>
HWY_INLINE auto dent(Load load) {
  return hn::Sub(hn::Add(load(-3), load(3)), hn::Add(load(0), load(0)));
}

/// g and h of the rows around y.
HWY_NOINLINE void down(int y, int count, Strip& s) {
  const hn::CappedTag<int16_t, most_lanes> d;
  const int16_t* rows[7];
  for (int k = 0; k < 7; ++k) rows[k] = s.boxes[(y + k + 4) % 7];
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < count; x += lanes) {
    const auto load = [&](int k) { return hn::LoadU(d, rows[3 + k] + x); };
    hn::StoreU(bell(load), d, s.smooth + x);
    hn::StoreU(dent(load), d, s.second + x);
  }
}

/// What both parts of the response are boxes of, in quarters.
HWY_NOINLINE void across(int count, Strip& s) {
  const hn::CappedTag<int16_t, most_lanes> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < count; x += lanes) {
    const auto smooth = [&](int k) { return hn::LoadU(d, s.smooth + x + 3 + k); };
    const auto second = [&](int k) { return hn::LoadU(d, s.second + x + 3 + k); };
    const auto sum = hn::SaturatedAdd(bell(second), hn::Add(dent(smooth), hn::Set(d, 2)));
    hn::StoreU(hn::ShiftRight<2>(sum), d, s.sums + x);
  }
}

template <int window>
HWY_NOINLINE void finish(const int16_t* sums, int cap, int count, uint8_t* to) {
  const hn::CappedTag<int16_t, most_lanes> d;
  each_step(d, count, [&](auto tag, int x) {
    const hn::Rebind<uint8_t, decltype(tag)> d8;
    constexpr int shift = window == 9 ? 4 : 5;
    const auto load = [&](int k) { return hn::LoadU(tag, sums + x + k); };
    const auto most = hn::Set(tag, static_cast<int16_t>(cap)), least = hn::Set(tag, static_cast<int16_t>(-cap));
    auto response = hn::Add(hn::Add(load(0), load(1)), load(2));
    if constexpr (window == 11) response = hn::Add(response, hn::Add(load(3), load(4)));
    response = hn::ShiftRight<shift>(hn::Add(response, hn::Set(tag, 1 << shift >> 1)));
    hn::StoreU(hn::DemoteTo(d8, hn::Add(hn::Min(hn::Max(response, least), most), most)), d8, to + x);
  });
}

template <int window>
HWY_INLINE void log_strips(View8 in, int cap, int first, int last, Plane<uint8_t> out) {
  Strip s;
  for (int from = 0; from < in.width; from += strip) {
    const int to = std::min(from + strip, in.width);
    // The last step first: each reads what the one before it left in the round before. To read at once what was just stored, a pixel beside
    // where it was stored, waits for the store.
    for (int y = first - 3; y < last + 6; ++y) {
      if (y >= first + 6) finish<window>(s.sums, cap, to - from, out.row(y - 6) + from);
      if (y >= first + 5) across(to - from + window - 7, s);
      if (y >= first + 4) down(y - 4, to - from + window - 1, s);
      sum_boxes<window>(in, y, from, to, s.boxes[(y + 7) % 7]);
    }
  }
}

void log_filter(View8 in, int window, int cap, int first, int last, Plane<uint8_t> out) {
  (window == 9 ? log_strips<9> : log_strips<11>)(in, cap, first, last, out);
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(x_sobel);
HWY_EXPORT(log_filter);
void choose_prefilter(Kernels& table) {
  table.x_sobel = VDISP_CHOSEN(x_sobel);
  table.log_filter = VDISP_CHOSEN(log_filter);
}
}  // namespace vdisp::kernels
#endif
