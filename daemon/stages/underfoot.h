// underfoot.h: part of `floor`: the plane that the rover stands on, where all that is seen of the ground is a slope ahead.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "config/config.h"
#include "daemon/geometry/floor_plane.h"

namespace vdisp {

/// A rover before the foot of a ramp sees nothing of the ground that it stands on, and the ramp's plane passes over or under its wheels:
/// the camera is not as high over it as was measured with a tape. Where that is so, and the plane told by [mounting] meets the ground seen
/// at its near end, that is the floor, and what is seen is the profile on it. `seen`: the plane found; `near_row`: v - cy of the lowest
/// row; `turned`: the last floor as the camera turned since, or null. None where what is seen is the floor, or nothing was told.
std::optional<FloorPlane> plane_underfoot(const FloorPlane& seen, double near_row, const FloorPlane* turned, const StereoView& view,
                                          const Config& config);

}  // namespace vdisp
