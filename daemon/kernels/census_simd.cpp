// census_simd.cpp: the census for all instruction sets: this file is compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/census_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void census3x3(View8 in, int first, int last, Plane<uint8_t> out) { plain::census3x3(in, first, last, out); }
void census5x5(View8 in, int first, int last, Plane<uint8_t> out, Plane<uint8_t> more) { plain::census5x5(in, first, last, out, more); }
#else

/// body(x) for steps of `lanes` columns that cover [from, to), the last one moved back onto the end: what it writes twice is the same.
/// border(x) for each column outside them, and for all where a step does not fit.
template <class Body, class Border>
HWY_INLINE void each_step(int lanes, int from, int to, int width, Body body, Border border) {
  if (to - from < lanes) {
    for (int x = 0; x < width; ++x) border(x);
    return;
  }
  for (int x = 0; x < from; ++x) border(x);
  for (int x = to; x < width; ++x) border(x);
  int x = from;
  for (; x + lanes <= to; x += lanes) body(x);
  if (x < to) body(to - lanes);
}

void census3x3(View8 in, int first, int last, Plane<uint8_t> out) {
  const hn::ScalableTag<uint8_t> d;
  const uint8_t* rows[3];
  for (int y = first; y < last; ++y) {
    rows_around(in, y, 3, rows);
    uint8_t* to = out.row(y);
    const auto body = [&](int x) HWY_ATTR {
      const auto centre = hn::LoadU(d, rows[1] + x);
      const auto bit = [&](int dy, int dx, int place) HWY_ATTR {
        return hn::IfThenElseZero(hn::Gt(centre, hn::LoadU(d, rows[1 + dy] + x + dx)), hn::Set(d, static_cast<uint8_t>(1 << place)));
      };
      const auto above = hn::Or(hn::Or(bit(-1, -1, 7), bit(-1, 0, 6)), bit(-1, 1, 5));
      const auto below = hn::Or(hn::Or(bit(1, -1, 2), bit(1, 0, 1)), bit(1, 1, 0));
      hn::StoreU(hn::Or(hn::Or(above, below), hn::Or(bit(0, -1, 4), bit(0, 1, 3))), d, to + x);
    };
    each_step(static_cast<int>(hn::Lanes(d)), 1, in.width - 1, in.width, body,
              [&](int x) { to[x] = plain::census3x3_at(rows, x, in.width); });
  }
}

void census5x5(View8 in, int first, int last, Plane<uint8_t> out, Plane<uint8_t> more) {
  const hn::ScalableTag<uint8_t> d;
  const uint8_t* rows[5];
  for (int y = first; y < last; ++y) {
    rows_around(in, y, 5, rows);
    uint8_t *to = out.row(y), *to_more = more.row(y);
    const auto body = [&](int x) HWY_ATTR {
      const auto bit = [&](int dy, int dx, int place) HWY_ATTR {
        const auto here = hn::LoadU(d, rows[2 + dy] + x + dx), there = hn::LoadU(d, rows[2 - dy] + x - dx);
        return hn::IfThenElseZero(hn::Gt(here, there), hn::Set(d, static_cast<uint8_t>(1 << place)));
      };
      const auto upper = hn::Or(hn::Or(hn::Or(bit(-2, -2, 7), bit(-2, -1, 6)), hn::Or(bit(-2, 0, 5), bit(-2, 1, 4))), bit(-2, 2, 3));
      hn::StoreU(hn::Or(upper, hn::Or(hn::Or(bit(-1, -2, 2), bit(-1, -1, 1)), bit(-1, 0, 0))), d, to + x);
      hn::StoreU(hn::Or(hn::Or(bit(-1, 1, 3), bit(-1, 2, 2)), hn::Or(bit(0, -2, 1), bit(0, -1, 0))), d, to_more + x);
    };
    each_step(static_cast<int>(hn::Lanes(d)), 2, in.width - 2, in.width, body, [&](int x) {
      const int code = plain::census5x5_at(rows, x, in.width);
      to[x] = static_cast<uint8_t>(code >> 4);
      to_more[x] = static_cast<uint8_t>(code & 15);
    });
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(census3x3);
HWY_EXPORT(census5x5);
void choose_census(Kernels& table) {
  table.census3x3 = VDISP_CHOSEN(census3x3);
  table.census5x5 = VDISP_CHOSEN(census5x5);
}
}  // namespace vdisp::kernels
#endif
