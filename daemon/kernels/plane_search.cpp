// plane_search.cpp: the plain form.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/plane_search.h"

#include <cmath>

namespace vdisp::kernels::plain {

PlaneCount count_on_plane(const DisparityPoints& points, size_t n, const DisparityPlane& plane, const PlaneReach& reach) {
  PlaneCount count{};
  for (size_t i = 0; i < n; ++i) {
    const float floor = plane.across * points.u[i] + plane.down * points.v[i] + plane.middle;
    const float off = points.d[i] - floor, within = reach.share * floor + reach.reach;
    if (!(floor > 0)) continue;
    count.on += std::abs(off) < within;
    count.beyond += off < -2 * within;
  }
  return count;
}

PlaneSums sum_on_plane(const DisparityPoints& points, size_t n, const PlaneFit& plane) {
  double sums[9][plane_parts] = {};
  for (size_t i = 0; i < n; ++i) {
    const double u = static_cast<double>(points.u[i]), v = static_cast<double>(points.v[i]), d = static_cast<double>(points.d[i]);
    const double floor = plane.across * u + plane.down * v + plane.middle, within = plane.share * floor + plane.reach,
                 off = (d - floor) / (d > floor ? within * plane.nearer_side : within), near = 1 - off * off;
    if (!(floor > 0 && near > 0)) continue;
    const double weight = near * near, by_u = weight * u, by_v = weight * v;
    const double parts[] = {by_u * u, by_u * v, by_u, by_u * d, by_v * v, by_v, by_v * d, weight, weight * d};
    for (size_t k = 0; k < 9; ++k) sums[k][i % plane_parts] += parts[k];
  }
  return whole(sums);
}

}  // namespace vdisp::kernels::plain
