// gravity.h: part of `floor`: what an IMU tells of how the camera turned since the last floor was found.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "config/config.h"
#include "daemon/geometry/frames.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// Gravity does not say where the floor is: on a slope a rover stands askew in the world and upright on its floor. But the ground ahead
/// stays where it is in the world while the rover nods, so from one frame to the next the floor turns, as the camera sees it, the way
/// gravity does. With rates of turn the attitude follows them, and the accelerometer corrects it within a second; without them it is the
/// accelerometer's.
///
/// A sample is not used where it comes late, is not g, jumps, or says that the rover lies on its side; and none is used while
/// predictions are worse than taking the floor to be where it was.
class Gravity {
 public:
  explicit Gravity(const Config& config) : config_(config) {}

  /// The sample of this frame; `pitch`: of the camera on the rover. Once a frame, before the others.
  void take(const Imu* imu, double pitch) noexcept;
  ImuUse use() const { return use_; }
  /// Straight down in camera frame, if what was taken can be used.
  std::optional<Point> down() const;
  /// Straight down on the floor last found (camera frame), turned as the camera turned since; none where that is not known.
  std::optional<Point> predicted() const;
  /// A floor was found: straight down on it, camera frame. Predictions are compared with it.
  void found(const Point& normal) noexcept;

  /// As before the first frame.
  void forget() noexcept;

 private:
  ImuUse judge(const Imu& imu, double pitch) noexcept;
  void begin(const Point& down) noexcept;
  void compare(const Point& normal) noexcept;

  const Config& config_;
  ImuUse use_ = ImuUse::none;
  bool contradicts_ = false;
  int64_t newest_ns_ = 0;                     // of the samples that were followed
  std::optional<Point> down_;                 // as followed
  Point rate_{};                              // of the newest sample, camera frame, rad/s
  std::optional<Point> last_, turned_;        // normal of the last floor, and as turned since
  double off_predicted_ = 0, off_still_ = 0;  // squares, of the last frames
};

}  // namespace vdisp
