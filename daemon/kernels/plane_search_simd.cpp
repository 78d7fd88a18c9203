// plane_search_simd.cpp: counting points on a plane for all instruction sets.
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
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(count_on_plane);
void choose_plane_search(Kernels& table) { table.count_on_plane = VDISP_CHOSEN(count_on_plane); }
}  // namespace vdisp::kernels
#endif
