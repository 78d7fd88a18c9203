// frames.h: which axis is which: camera frame c, horizontal frame h, and the floor as a line in the v-disparity.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace vdisp {

/// A point in m. Camera frame c: origin at the left focal point, x right, y down, z along the view (paper 2.2, SVS).
/// Horizontal frame h: same origin, x right, y straight down, z ahead. Height over the camera is -y.
struct Point {
  double x, y, z;
};

/// c to h: paper equation 3, with the pitch t positive when the camera looks down (angRot). Roll, positive when the camera's
/// right side is low, is undone first.
inline Point horizontal(const Point& c, double pitch, double roll = 0) {
  const double x = c.x * std::cos(roll) - c.y * std::sin(roll);
  const double y = c.x * std::sin(roll) + c.y * std::cos(roll);
  return {x, y * std::cos(pitch) + c.z * std::sin(pitch), c.z * std::cos(pitch) - y * std::sin(pitch)};
}

/// h to c, for many points of one frame: paper equation 2, the inverse of horizontal().
struct ToCamera {
  double sin_pitch, cos_pitch, sin_roll, cos_roll;
  explicit ToCamera(double pitch, double roll = 0)
      : sin_pitch(std::sin(pitch)), cos_pitch(std::cos(pitch)), sin_roll(std::sin(roll)), cos_roll(std::cos(roll)) {}
  Point operator()(const Point& h) const {
    const double y = h.y * cos_pitch - h.z * sin_pitch;
    const double z = h.y * sin_pitch + h.z * cos_pitch;
    return {h.x * cos_roll + y * sin_roll, -h.x * sin_roll + y * cos_roll, z};
  }
};
inline Point camera(const Point& h, double pitch, double roll = 0) { return ToCamera(pitch, roll)(h); }

/// A rectified stereo view as the projection needs it. f in px, baseline in m, cx_offset = cx left - cx right in px.
struct StereoView {
  double f = 0, cx = 0, cy = 0, baseline = 0, cx_offset = 0;
  bool calibrated() const { return f > 0 && baseline > 0; }

  /// The point seen at column u, row v with disparity d (px, d > cx_offset): Z = f B / (d - cx_offset).
  Point point(double u, double v, double d) const {
    const double z = f * baseline / (d - cx_offset);
    return {(u - cx) * z / f, (v - cy) * z / f, z};
  }
  double disparity(double z) const { return f * baseline / z + cx_offset; }
};

/// A line in the v-disparity in pixels: row v = slope * d' + row0, where d' = d - cx_offset (px) is 0 at infinity.
struct FloorLine {
  double slope, row0;
  double row(double true_disparity) const { return slope * true_disparity + row0; }
};

/// Flat floor at `height` m below a camera pitched by `pitch`: v = cy - f tan t + d' H / (B cos t).
inline FloorLine floor_line(const StereoView& view, double height, double pitch) {
  return {height / (view.baseline * std::cos(pitch)), view.cy - view.f * std::tan(pitch)};
}

/// Pitch and camera height of a line: the inverse of floor_line().
struct FloorPose {
  double pitch, height;
};
inline FloorPose floor_pose(const StereoView& view, const FloorLine& line) {
  const double pitch = std::atan((view.cy - line.row0) / view.f);
  return {pitch, line.slope * view.baseline * std::cos(pitch)};
}

/// Nearest floor that the lowest image row sees, m ahead of the camera: H / tan(t + half the field of view), below the axis.
/// The paper's equation 1 as printed, tan(FOV/2 * t) * h, gives no metre; this gives its "one meter".
inline double nearest_floor(double height, double pitch, double half_view) { return height / std::tan(pitch + half_view); }

/// Depth along the view, m, from which on things have a disparity of at most `most` px: nearer ones cannot be matched.
inline double nearest_matched(const StereoView& view, double most) { return view.f * view.baseline / (most - view.cx_offset); }

/// Distance ahead, m, of the floor at this depth along the view.
inline double floor_ahead(double depth, double height, double pitch) { return (depth - height * std::sin(pitch)) / std::cos(pitch); }

/// In the rover frame r (REP-103: x forward, y left, z up, origin on the ground) a point of frame h, for a camera mounted at
/// (x, y), turned left by yaw, `height` over the ground.
inline Point rover(const Point& h, double x, double y, double yaw, double height) {
  const double forward = h.z, left = -h.x;
  return {x + forward * std::cos(yaw) - left * std::sin(yaw), y + forward * std::sin(yaw) + left * std::cos(yaw), height - h.y};
}

}  // namespace vdisp
