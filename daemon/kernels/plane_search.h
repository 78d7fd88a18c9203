// plane_search.h: contract: points of the disparity image on a plane and beyond it, counted, and summed up for a fit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace vdisp::kernels {

/// Points (u - cx, v - cy, d'), px, as three lists with room for point_room(n) each, and numbers in all of it.
struct DisparityPoints {
  float *u, *v, *d;
};

/// d' = across u + down v + middle.
struct DisparityPlane {
  float across, down, middle;
};

/// What lies within reach + share d' of the plane is on it; what is farther by more than twice that is beyond: through a floor nothing is
/// seen. Only what lies below the plane's horizon (d' > 0) counts.
struct PlaneReach {
  float reach, share;
};

struct PlaneCount {
  uint32_t on, beyond;
  bool operator==(const PlaneCount&) const = default;
};

using CountOnPlane = PlaneCount(const DisparityPoints& points, size_t n, const DisparityPlane& plane, const PlaneReach& reach);

/// A plane to be fitted anew to what lies within reach + share d' of it, or on the nearer side within that times `nearer_side`.
struct PlaneFit {
  double across, down, middle;
  double reach, share, nearer_side;
};

/// Sums over points by Tukey's weight (1 - off^2)^2, off: of where it is 0; `d`: of weight times d', `uv`: times u v, `one`: the weights.
struct PlaneSums {
  double uu, uv, u, ud, vv, v, vd, one, d;
  bool operator==(const PlaneSums&) const = default;
};

/// Every fourth point is summed up by itself, and then the four sums, so that it is the same on every machine.
using SumOnPlane = PlaneSums(const DisparityPoints& points, size_t n, const PlaneFit& plane);
inline constexpr size_t plane_parts = 4;
inline PlaneSums whole(const double (&sums)[9][plane_parts]) {
  const auto sum = [&](size_t i) { return (sums[i][0] + sums[i][1]) + (sums[i][2] + sums[i][3]); };
  return {sum(0), sum(1), sum(2), sum(3), sum(4), sum(5), sum(6), sum(7), sum(8)};
}

namespace plain {
CountOnPlane count_on_plane;
SumOnPlane sum_on_plane;
}  // namespace plain

}  // namespace vdisp::kernels
