// height_simd.cpp: heights over the local floor for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/height_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                     const HeightOut& out) {
  plain::measure_heights(disparity, n, search, row, table, out);
}
#else

/// What is left of a row after the vectors. The same products: columns go on where the vectors ended.
void measure_rest(const int16_t* disparity, int first, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                  const HeightOut& out) {
  HeightRow rest = row;
  rest.step = 0;
  for (int u = first; u < n; ++u) {
    rest.first = row.step * static_cast<float>(u) + row.first;
    plain::measure_heights(disparity + u, 1, search, rest, table,
                           {out.height + u, out.surface + u, out.obstacles + u, out.overhangs + u, out.none, out.refused});
  }
}

void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                     const HeightOut& out) {
  const hn::ScalableTag<int16_t> d16;
  const hn::RepartitionToWide<decltype(d16)> di;
  const hn::RebindToFloat<decltype(di)> df;
  const hn::RepartitionToWide<decltype(di)> d64;
  const hn::Half<decltype(d16)> half16;
  const hn::Half<decltype(di)> half32;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16)), half = lanes / 2;
  const auto camera = hn::Set(df, row.camera), first = hn::Set(df, row.first), step = hn::Set(df, row.step);
  const auto most = hn::Set(df, 32000.0f), least = hn::Set(df, -32000.0f);
  const auto number = [&](int value) HWY_ATTR { return hn::Set(d16, static_cast<int16_t>(value)); };
  const auto is = [&](Surface surface) HWY_ATTR { return number(static_cast<int>(surface)); };
  const auto origin = number(search.first), before = number(search.least - 1), end = number(search.end());
  const auto below_step = number(row.step_mm - 1), below_clearance = number(row.clearance_mm - 1), over_hole = number(1 - row.hole_mm);
  const auto none = number(out.none), refused = number(out.refused);
  // Pairs of floats: inverse, profile, inverse, profile...
  const auto look_up = [&](auto index) HWY_ATTR { return hn::BitCast(df, hn::GatherIndex(d64, table.heights, hn::PromoteTo(d64, index))); };
  const auto measure = [&](auto index16, auto column) HWY_ATTR {
    const auto index = hn::PromoteTo(di, index16);
    const auto near = look_up(hn::LowerHalf(index)), far = look_up(hn::UpperHalf(half32, index));
    // Multiplied and added one after the other, as in the plain form: a fused step would round differently.
    const auto floor = hn::Add(hn::Mul(step, column), first);
    const auto fallen = hn::Sub(camera, hn::Mul(floor, hn::ConcatEven(df, far, near)));
    const auto height = hn::Sub(fallen, hn::ConcatOdd(df, far, near));
    return hn::DemoteTo(half16, hn::ConvertTo(di, hn::Min(hn::Max(height, least), most)));
  };
  const auto store = [&](int u, auto height, auto surface, auto obstacles, auto overhangs) HWY_ATTR {
    hn::StoreU(height, d16, out.height + u);
    hn::StoreU(hn::DemoteTo(d8, surface), d8, out.surface + u);
    hn::StoreU(obstacles, d16, out.obstacles + u);
    hn::StoreU(overhangs, d16, out.overhangs + u);
  };
  auto column = hn::Iota(df, 0.0f);
  const auto next_columns = hn::Set(df, static_cast<float>(half));
  int u = 0;
  for (; u + lanes <= n; u += lanes) {
    const auto left = column, right = hn::Add(column, next_columns);
    column = hn::Add(right, next_columns);
    const auto d = hn::LoadU(d16, disparity + u);
    const auto counts = hn::And(hn::Gt(d, before), hn::Lt(d, end));
    if (hn::AllFalse(d16, counts)) {
      store(u, none, hn::Zero(d16), refused, refused);
      continue;
    }
    const auto index = hn::IfThenElseZero(counts, hn::Sub(d, origin));
    const auto mm = hn::Combine(d16, measure(hn::UpperHalf(half16, index), right), measure(hn::LowerHalf(index), left));
    const auto above = hn::And(counts, hn::Gt(mm, below_step)), over = hn::And(counts, hn::Gt(mm, below_clearance));
    auto surface = hn::IfThenElse(above, is(Surface::obstacle), hn::IfThenElseZero(counts, is(Surface::floor)));
    surface = hn::IfThenElse(over, is(Surface::overhang), surface);
    surface = hn::IfThenElse(hn::And(counts, hn::Lt(mm, over_hole)), is(Surface::below), surface);
    store(u, hn::IfThenElse(counts, mm, none), surface, hn::IfThenElse(hn::Eq(surface, is(Surface::obstacle)), d, refused),
          hn::IfThenElse(hn::Eq(surface, is(Surface::overhang)), d, refused));
  }
  measure_rest(disparity, u, n, search, row, table, out);
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(measure_heights);
void choose_height(Kernels& table) { table.measure_heights = VDISP_CHOSEN(measure_heights); }
}  // namespace vdisp::kernels
#endif
