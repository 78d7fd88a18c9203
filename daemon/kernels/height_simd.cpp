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
void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTables& tables,
                     const HeightOut& out) {
  plain::measure_heights(disparity, n, search, row, tables, out);
}
#else

void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTables& tables,
                     const HeightOut& out) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::Rebind<int16_t, decltype(df)> d16;
  const hn::Rebind<uint8_t, decltype(df)> d8;
  const int lanes = static_cast<int>(hn::Lanes(df));
  const auto camera = hn::Set(df, row.camera), first = hn::Set(df, row.first), step = hn::Set(df, row.step);
  const auto step_mm = hn::Set(df, row.step_mm), clearance = hn::Set(df, row.clearance_mm), hole = hn::Set(df, -row.hole_mm);
  const auto most = hn::Set(df, 32000.0f), least = hn::Set(df, -32000.0f);
  const auto origin = hn::Set(di, search.first), before = hn::Set(di, search.least - 1), end = hn::Set(di, search.end());
  const auto none = hn::Set(di, out.none), refused = hn::Set(di, out.refused);
  const auto is = [&](Surface surface) HWY_ATTR { return hn::Set(di, static_cast<int32_t>(surface)); };
  int u = 0;
  for (; u + lanes <= n; u += lanes) {
    const auto d = hn::PromoteTo(di, hn::LoadU(d16, disparity + u));
    const auto counts = hn::And(hn::Gt(d, before), hn::Lt(d, end));
    const auto index = hn::IfThenElseZero(counts, hn::Sub(d, origin));
    const auto column = hn::ConvertTo(df, hn::Add(hn::Iota(di, 0), hn::Set(di, u)));
    // Multiplied and added one after the other, as in the plain form: a fused step would round differently.
    const auto floor = hn::Add(hn::Mul(step, column), first);
    const auto fallen = hn::Sub(camera, hn::Mul(floor, hn::GatherIndex(df, tables.inverse, index)));
    const auto height = hn::Sub(fallen, hn::GatherIndex(df, tables.profile, index));
    const auto mm = hn::ConvertTo(di, hn::Min(hn::Max(height, least), most));
    auto surface = hn::IfThenElse(hn::RebindMask(di, hn::Gt(height, step_mm)), is(Surface::obstacle), is(Surface::floor));
    surface = hn::IfThenElse(hn::RebindMask(di, hn::Ge(height, clearance)), is(Surface::overhang), surface);
    surface = hn::IfThenElse(hn::RebindMask(di, hn::Lt(height, hole)), is(Surface::below), surface);
    surface = hn::IfThenElseZero(counts, surface);
    const auto narrow = [&](auto v, int16_t* to) HWY_ATTR { hn::StoreU(hn::DemoteTo(d16, v), d16, to + u); };
    narrow(hn::IfThenElse(counts, mm, none), out.height);
    narrow(hn::IfThenElse(hn::Eq(surface, is(Surface::obstacle)), d, refused), out.obstacles);
    narrow(hn::IfThenElse(hn::Eq(surface, is(Surface::overhang)), d, refused), out.overhangs);
    hn::StoreU(hn::DemoteTo(d8, surface), d8, out.surface + u);
  }
  if (u == n) return;
  HeightRow rest = row;
  const HeightOut rest_out{out.height + u, out.surface + u, out.obstacles + u, out.overhangs + u, out.none, out.refused};
  // The same products: columns go on where the vectors ended.
  for (int k = 0; u + k < n; ++k) {
    rest.first = row.step * static_cast<float>(u + k) + row.first;
    rest.step = 0;
    const HeightOut one{rest_out.height + k, rest_out.surface + k, rest_out.obstacles + k, rest_out.overhangs + k, out.none, out.refused};
    plain::measure_heights(disparity + u + k, 1, search, rest, tables, one);
  }
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
