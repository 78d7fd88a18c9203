// recorded_step.h: one step of the daemon as a recording keeps it: when, whether there was a pair, and what had come in.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// What the rover did, or should do, when a pair was taken (census + SNoW, section 4). none: nobody told.
enum class Label : uint32_t { none = 0, forward, left, right, count };
std::string_view name(Label label);
Label label_of(Steering steering);
/// Of an order: a turn by more than `least_turn` is one to that side; without one it is forward where the rover is to move ahead.
Label label_of(double speed, double turn_rate);
inline constexpr double least_turn = 0.1;  ///< rad/s

/// An image of in/...: its header where that is its own, and its record.
template <class Record>
struct RecordedInput {
  Reason reason = Reason::none;  ///< why it was blind; none: it was valid
  uint32_t flags = 0;            ///< ImageFlag
  int64_t timestamp_ns = 0;
  Record record{};
};

/// As the tree saw it: inputs are sampled once a step.
struct RecordedStep {
  uint64_t sequence = 0;
  int64_t timestamp_ns = 0;      ///< of camera/left; CLOCK_MONOTONIC, or what the recorded source gave
  Reason reason = Reason::none;  ///< why there was no pair; none: there was
  uint32_t flags = 0;            ///< ImageFlag of camera/left
  uint64_t config_generation = 0;
  RecordedInput<Odometry> odometry;
  RecordedInput<Imu> imu;
  RecordedInput<DriveOrder> drive;
  RecordedInput<Events> event;

  bool has_pair() const { return reason == Reason::none; }
};

/// Both views of a step, and what was to be done. Rows are `stride` bytes apart.
struct RecordedViews {
  const uint8_t* left = nullptr;
  const uint8_t* right = nullptr;
  uint32_t stride = 0;
  Label label = Label::none;
  double speed = std::nan(""), turn_rate = std::nan("");  ///< m/s, rad/s; NaN: nobody told
};

}  // namespace vdisp
