// plane_fit.cpp: weighted least squares, until they settle.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/plane_fit.h"

#include <cmath>

namespace vdisp {
namespace {

constexpr double nearer_side = 0.7;
constexpr double still = 0.01;  // px

}  // namespace

FloorPlane fitted(const FloorPlane& plane, const PlanePoints& points, double wider, const kernels::Kernels& kernels) {
  const kernels::PlaneFit fit{plane.across,
                              plane.down,
                              plane.middle,
                              wider * static_cast<double>(plane_reach.reach),
                              wider * static_cast<double>(plane_reach.share),
                              nearer_side};
  const auto [uu, uv, u, ud, vv, v, vd, one, d] = kernels.sum_on_plane(points.lists, points.n, fit);
  double s[3][4] = {{uu, uv, u, ud}, {uv, vv, v, vd}, {u, v, one, d}};
  for (int r = 0; r < 3; ++r) {
    if (std::abs(s[r][r]) < 1e-6) return plane;
    for (int other = 0; other < 3; ++other) {
      if (other == r) continue;
      const double factor = s[other][r] / s[r][r];
      for (int c = r; c < 4; ++c) s[other][c] -= factor * s[r][c];
    }
  }
  return {s[0][3] / s[0][0], s[1][3] / s[1][1], s[2][3] / s[2][2]};
}

FloorPlane settled(FloorPlane plane, const PlanePoints& points, int most, const kernels::Kernels& kernels) {
  for (int i = 0; i < most; ++i) {
    const FloorPlane before = plane;
    plane = fitted(before, points, 1, kernels);
    const double moved = std::abs(plane.across - before.across) * points.half_width +
                         std::abs(plane.down - before.down) * points.half_height + std::abs(plane.middle - before.middle);
    if (!(moved >= still)) break;
  }
  return plane;
}

}  // namespace vdisp
