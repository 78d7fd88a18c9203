// plane_search_simd.cpp: counting and summing up points on a plane for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/plane_search_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
PlaneCount count_on_plane(const DisparityPoints& points, size_t n, const DisparityPlane& plane, const PlaneReach& reach) {
  return plain::count_on_plane(points, n, plane, reach);
}
PlaneSums sum_on_plane(const DisparityPoints& points, size_t n, const PlaneFit& plane) { return plain::sum_on_plane(points, n, plane); }
#else

PlaneCount count_on_plane(const DisparityPoints& points, size_t n, const DisparityPlane& plane, const PlaneReach& reach) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const size_t lanes = hn::Lanes(df);
  const auto across = hn::Set(df, plane.across), down = hn::Set(df, plane.down), middle = hn::Set(df, plane.middle);
  const auto share = hn::Set(df, reach.share), least = hn::Set(df, reach.reach), minus_two = hn::Set(df, -2.0f), zero = hn::Zero(df);
  auto on = hn::Zero(di), beyond = hn::Zero(di);
  const auto step = [&](size_t i, auto there) HWY_ATTR {
    // Multiplied and added one after the other, as in the plain form: a fused step would round differently.
    const auto sum = hn::Add(hn::Mul(across, hn::LoadU(df, points.u + i)), hn::Mul(down, hn::LoadU(df, points.v + i)));
    const auto floor = hn::Add(sum, middle);
    const auto off = hn::Sub(hn::LoadU(df, points.d + i), floor), within = hn::Add(hn::Mul(share, floor), least);
    const auto below = hn::And(there, hn::Gt(floor, zero));
    const auto is_on = hn::And(below, hn::Lt(hn::Abs(off), within));
    const auto is_beyond = hn::And(below, hn::Lt(off, hn::Mul(minus_two, within)));
    on = hn::Sub(on, hn::VecFromMask(di, hn::RebindMask(di, is_on)));
    beyond = hn::Sub(beyond, hn::VecFromMask(di, hn::RebindMask(di, is_beyond)));
  };
  size_t i = 0;
  const auto whole = hn::FirstN(df, lanes);
  for (; i + lanes <= n; i += lanes) step(i, whole);
  if (i < n) step(i, hn::FirstN(df, n - i));
  return {static_cast<uint32_t>(hn::GetLane(hn::SumOfLanes(di, on))), static_cast<uint32_t>(hn::GetLane(hn::SumOfLanes(di, beyond)))};
}

PlaneSums sum_on_plane(const DisparityPoints& points, size_t n, const PlaneFit& plane) {
  const hn::CappedTag<double, plane_parts> d64;
  const hn::Rebind<float, decltype(d64)> d32;
  const size_t lanes = hn::Lanes(d64);
  const auto all = [&](double value) HWY_ATTR { return hn::Set(d64, value); };
  const auto across = all(plane.across), down = all(plane.down), middle = all(plane.middle), reach = all(plane.reach),
             share = all(plane.share), nearer = all(plane.nearer_side), one = all(1), zero = hn::Zero(d64);
  alignas(64) double sums[9][plane_parts] = {};
  for (size_t i = 0; i < n; i += lanes) {
    const auto get = [&](const float* list) HWY_ATTR { return hn::PromoteTo(d64, hn::LoadU(d32, list + i)); };
    const auto u = get(points.u), v = get(points.v), d = get(points.d);
    const auto floor = hn::Add(hn::Add(hn::Mul(across, u), hn::Mul(down, v)), middle);
    const auto within = hn::Add(hn::Mul(share, floor), reach);
    const auto off = hn::Div(hn::Sub(d, floor), hn::IfThenElse(hn::Gt(d, floor), hn::Mul(within, nearer), within));
    const auto near = hn::Sub(one, hn::Mul(off, off));
    const auto counts = hn::And(hn::And(hn::Gt(floor, zero), hn::Gt(near, zero)), hn::FirstN(d64, n - i));
    const auto weight = hn::IfThenElseZero(counts, hn::Mul(near, near)), by_u = hn::Mul(weight, u), by_v = hn::Mul(weight, v);
    const auto add = [&](size_t k, auto part) HWY_ATTR {
      double* to = sums[k] + i % plane_parts;
      hn::StoreU(hn::Add(hn::LoadU(d64, to), part), d64, to);
    };
    add(0, hn::Mul(by_u, u));
    add(1, hn::Mul(by_u, v));
    add(2, by_u);
    add(3, hn::Mul(by_u, d));
    add(4, hn::Mul(by_v, v));
    add(5, by_v);
    add(6, hn::Mul(by_v, d));
    add(7, weight);
    add(8, hn::Mul(weight, d));
  }
  return whole(sums);
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(count_on_plane);
HWY_EXPORT(sum_on_plane);
void choose_plane_search(Kernels& table) {
  table.count_on_plane = VDISP_CHOSEN(count_on_plane);
  table.sum_on_plane = VDISP_CHOSEN(sum_on_plane);
}
}  // namespace vdisp::kernels
#endif
