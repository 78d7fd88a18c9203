// edges.h: says once when something is lost and once when it is back, never once a frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "config/config.h"
#include "daemon/core/driver.h"

namespace vdisp::log {

/// Looks at the images of a step before they are published: camera, floor, mounting, what comes in. What changes faster than once a second
/// is counted and told with the next line.
class Edges {
 public:
  /// `fault` tells what is wrong with the pair at hand, more than the image's reason does; empty: nothing.
  Edges(const Config& config, std::function<std::string_view()> fault) : config_(config), fault_(std::move(fault)) {}
  void see(const Topic& topic, const Image& image);

 private:
  struct Subject {
    bool lost = false, told_lost = false;
    int64_t since_ns = 0, found_ns = 0, told_ns = INT64_MIN / 2;
    int untold = 0;
  };
  /// Of one kind of message that comes in.
  struct Incoming {
    Subject subject;
    uint64_t refused = 0, refused_before = 0;  // told and not; when the refusals at hand began
    int64_t refused_ns = 0;
    bool refusing = false;
  };
  void incoming(Incoming& kind, const char* what, const InputTally& tally, const Image& image);
  void edge(Subject& subject, const char* what, std::string_view fault, const Image& image);
  void compare(const FloorModel& model, const Image& image);
  void remember(const Memory& memory, const Image& image);
  void weigh(const FloorModel& model, const Image& image);
  void watch_calibration(const CalibrationWatch& watch, const Image& image);
  void judge_imu(const FloorModel& model, const Image& image);
  void say_what_is_near(const FloorModel& model, const CameraGeometry& camera);

  const Config& config_;
  std::function<std::string_view()> fault_;
  Subject camera_, floor_;
  Incoming odometry_, imu_, drive_, event_;
  int rows_ = 0;  // of the images
  bool told_near_ = false;
  bool differs_ = false;
  bool fused_ = false;  // as last told
  int64_t memory_told_ns_ = INT64_MIN / 2;
  bool forgetting_ = false;  // within the last two seconds
  uint32_t forgotten_ = 0, forgotten_before_ = 0;
  int64_t forgotten_ns_ = 0;
  int frames_otherwise_ = 0;  // in a row that contradict differs_
  bool askew_ = false, imu_ignored_ = false;
  int weighed_otherwise_ = 0;  // in a row that contradict askew_
  int64_t imu_told_ns_ = INT64_MIN / 2;
  bool drifted_ = false;
  int64_t drift_told_ns_ = INT64_MIN / 2;
};

}  // namespace vdisp::log
