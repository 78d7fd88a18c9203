// floor_plane.h: the floor as a plane of true disparities, and as a plane in metres.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "daemon/geometry/frames.h"

namespace vdisp {

/// d' = across (u - cx) + down (v - cy) + middle, px: what the flat ground would have at column u, row v. With n the unit vector straight
/// down in the camera frame and H the height of the camera, d' = B / H (n.x (u - cx) + n.y (v - cy) + n.z f).
struct FloorPlane {
  double across = 0, down = 0, middle = 0;

  double at(double u, double v, const StereoView& view) const { return across * (u - view.cx) + down * (v - view.cy) + middle; }
  /// Row of the horizon in the middle column.
  double horizon(const StereoView& view) const { return view.cy - middle / down; }
};

/// The least and the greatest height of the camera over the plane of a ramp ahead, as parts of its height over the ground, the ramp `slope`
/// rad steep, positive: it rises. It begins at most where ground is first seen, up to 1.5 camera heights ahead, and is led on to the rover
/// from there: what rises lies farther below, what falls nearer. 0.35 to either side is how far off a gentle one may be found; 0.45 is what
/// falls by 16 degrees, and steeper ones may have: more is a table, or a wall that leans.
struct HeightRange {
  double least, most;
};
inline HeightRange height_over_ramp(double slope) {
  const double falls = 1 - std::cos(slope) - 1.5 * std::sin(slope), rises = std::cos(slope) - 1 + 1.5 * std::sin(slope);
  return {1 - std::clamp(falls, 0.35, 0.45), 1 + std::clamp(rises, 0.35, 0.45)};
}

struct PlanePose {
  double pitch, roll, height;  ///< rad, positive: looks down, right side low; m
};

inline PlanePose pose_of(const FloorPlane& plane, const StereoView& view) {
  const double x = plane.across, y = plane.down, z = plane.middle / view.f, length = std::hypot(x, y, z);
  return {std::atan2(z, std::hypot(x, y)), std::atan2(x, y), view.baseline / length};
}

inline FloorPlane plane_of(const PlanePose& pose, const StereoView& view) {
  const double scale = view.baseline / pose.height;
  return {scale * std::sin(pose.roll) * std::cos(pose.pitch), scale * std::cos(pose.roll) * std::cos(pose.pitch),
          scale * view.f * std::sin(pose.pitch)};
}

}  // namespace vdisp
