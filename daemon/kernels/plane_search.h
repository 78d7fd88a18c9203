// plane_search.h: contract: how many points of the disparity image lie on a plane, and how many beyond it.
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

namespace plain {
CountOnPlane count_on_plane;
}

}  // namespace vdisp::kernels
