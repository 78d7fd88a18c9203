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

}  // namespace vdisp::kernels::plain
