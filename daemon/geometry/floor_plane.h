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

/// By what part of the camera's height the plane of a ramp ahead may lie higher or lower under the camera, the ramp `slope` rad steep: it
/// begins at most where ground is first seen, up to 1.5 camera heights ahead, and is led on to the rover from there.
inline double height_of_ramp(double slope) { return std::clamp(1.5 * std::tan(std::abs(slope)), 0.35, 0.45); }

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
