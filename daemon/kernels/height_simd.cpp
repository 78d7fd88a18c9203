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

constexpr int block = 256;  // columns: a multiple of all vectors, and what they look up stays in the nearest cache

/// Looked up one by one: gathers took twice as long on an AMD EPYC. 0 stands for what does not count.
void look_up(const int16_t* disparity, int n, const Search& search, HeightTable table, HeightOf* found) {
  const hn::ScalableTag<int16_t> d16;
  HWY_ALIGN int16_t index[block];
  const auto number = [&](int value) HWY_ATTR { return hn::Set(d16, static_cast<int16_t>(value)); };
  const auto origin = number(search.first), before = number(search.least - 1), end = number(search.end());
  const int lanes = static_cast<int>(hn::Lanes(d16));
  for (int u = 0; u < n; u += lanes) {
    const auto d = hn::LoadU(d16, disparity + u);
    hn::Store(hn::IfThenElseZero(hn::And(hn::Gt(d, before), hn::Lt(d, end)), hn::Sub(d, origin)), d16, index + u);
  }
  for (int u = 0; u < n; ++u) found[u] = table[index[u]];
}

/// Height over the local floor, mm, of as many pixels as `column` has lanes.
template <class D, class Column>
HWY_INLINE auto height_of(D df, const HeightOf* found, Column column, const HeightRow& row) {
  const hn::RebindToSigned<D> di;
  hn::Vec<D> inverse, profile;
  hn::LoadInterleaved2(df, &found->inverse, inverse, profile);
  // Multiplied and added one after the other, as in the plain form: a fused step would round differently.
  const auto floor = hn::Add(hn::Mul(hn::Set(df, row.step), column), hn::Set(df, row.first));
  const auto height = hn::Sub(hn::Sub(hn::Set(df, row.camera), hn::Mul(floor, inverse)), profile);
  return hn::DemoteTo(hn::Rebind<int16_t, D>(), hn::ConvertTo(di, hn::Min(hn::Max(height, hn::Set(df, -32000.0f)), hn::Set(df, 32000.0f))));
}

void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                     const HeightOut& out) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::RebindToFloat<hn::RepartitionToWide<decltype(d16)> > df;
  const int lanes = static_cast<int>(hn::Lanes(d16)), half = lanes / 2, whole = n - n % lanes;
  const auto number = [&](int value) HWY_ATTR { return hn::Set(d16, static_cast<int16_t>(value)); };
  const auto is = [&](Surface surface) HWY_ATTR { return number(static_cast<int>(surface)); };
  const auto before = number(search.least - 1), end = number(search.end());
  const auto below_step = number(row.step_mm - 1), below_clearance = number(row.clearance_mm - 1), over_hole = number(1 - row.hole_mm);
  const auto none = number(out.none), refused = number(out.refused);
  HWY_ALIGN HeightOf found[block];
  auto column = hn::Iota(df, 0.0f);
  const auto next_columns = hn::Set(df, static_cast<float>(half));
  for (int u = 0; u < whole; u += lanes) {
    if (u % block == 0) look_up(disparity + u, std::min(block, whole - u), search, table, found);
    const HeightOf* const here = found + u % block;
    const auto d = hn::LoadU(d16, disparity + u);
    const auto counts = hn::And(hn::Gt(d, before), hn::Lt(d, end));
    const auto left = height_of(df, here, column, row);
    column = hn::Add(column, next_columns);
    const auto mm = hn::Combine(d16, height_of(df, here + half, column, row), left);
    column = hn::Add(column, next_columns);
    const auto above = hn::And(counts, hn::Gt(mm, below_step)), over = hn::And(counts, hn::Gt(mm, below_clearance));
    auto surface = hn::IfThenElse(above, is(Surface::obstacle), hn::IfThenElseZero(counts, is(Surface::floor)));
    surface = hn::IfThenElse(over, is(Surface::overhang), surface);
    surface = hn::IfThenElse(hn::And(counts, hn::Lt(mm, over_hole)), is(Surface::below), surface);
    hn::StoreU(hn::IfThenElse(counts, mm, none), d16, out.height + u);
    hn::StoreU(hn::DemoteTo(d8, surface), d8, out.surface + u);
    hn::StoreU(hn::IfThenElse(hn::Eq(surface, is(Surface::obstacle)), d, refused), d16, out.obstacles + u);
    hn::StoreU(hn::IfThenElse(hn::Eq(surface, is(Surface::overhang)), d, refused), d16, out.overhangs + u);
  }
  measure_rest(disparity, whole, n, search, row, table, out);
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
