// inputs.h: odometry, IMU, drive orders and events as they come: judged, the newest kept, and told to the tree once a step.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "config/config.h"
#include "ipc/command.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// One thread: the loop's. No call allocates or waits. Times are CLOCK_MONOTONIC in ns, `sender` is the connection's number.
class Inputs {
 public:
  explicit Inputs(const Config& config) : config_(config) {}

  /// The source of the frames tells odometry or IMU itself: what comes by the socket is refused (Refusal::recorded).
  void refuse_odometry() { recorded_ = true; }
  void refuse_imu() { recorded_imu_ = true; }
  /// A recording tells all: orders and events as well.
  void refuse_all() { recorded_ = recorded_imu_ = recorded_orders_ = true; }

  Refusal take(const OdometryMessage& message, uint64_t sender, int64_t now_ns);
  Refusal take(const ImuMessage& message, uint64_t sender, int64_t now_ns);
  Refusal take(const DriveMessage& message, uint64_t sender, int64_t now_ns);
  Refusal take(const EventMessage& message, uint64_t sender, int64_t now_ns);
  /// An event with the label `recording` was accepted since the last call: a recording begins, and the tree with it.
  bool recording_begins() { return std::exchange(recording_begins_, false); }
  /// The sender is gone: another one may follow it at once.
  void forget(uint64_t sender);

  /// Writes the newest of each kind into an image, blind where it is older than [control] maxAge at `now_ns` or nothing ever came.
  /// The counts of a step begin anew with each.
  void write_odometry(Image& image, int64_t now_ns);
  void write_imu(Image& image, int64_t now_ns);
  void write_drive(Image& image, int64_t now_ns);
  void write_events(Image& image, int64_t now_ns);
  const InputTally& odometry_tally() const { return odometry_.input.tally; }
  /// In the order of `input_names`.
  std::array<const InputTally*, 4> tallies() const {
    return {&odometry_.input.tally, &imu_.input.tally, &drive_.input.tally, &events_.input.tally};
  }

 private:
  /// What all kinds have in common.
  struct Input {
    int64_t newest_ns = INT64_MIN;  // timestamp of the newest accepted
    uint64_t sender = 0;            // 0: nobody
    int64_t heard_ns = 0;           // when it last sent anything
    InputTally tally{};
  };
  template <class Record>
  struct Kept {
    Input input;
    Record newest{};
  };

  Refusal judge(Input& input, int64_t timestamp_ns, uint64_t sender, int64_t now_ns, bool in_order) const;
  Refusal judge_motion(const OdometryMessage& message);
  bool moves_steadily(const OdometryMessage& from, const OdometryMessage& to) const;
  Refusal settle(Input& input, Refusal refusal, int64_t timestamp_ns);
  bool write_age(Input& input, Image& image, Reason none, int64_t now_ns, double& age_s) const;

  const Config& config_;
  bool recorded_ = false, recorded_imu_ = false, recorded_orders_ = false;
  Kept<Odometry> odometry_;
  Kept<Imu> imu_;
  Kept<DriveOrder> drive_;
  Kept<Events> events_;
  OdometryMessage last_{};       // accepted
  OdometryMessage elsewhere_{};  // the newest refused as a jump
  int64_t elsewhere_since_ = 0;  // from when on the refused samples agree with each other; 0: they do not
  uint32_t frame_ = 0;
  bool recording_begins_ = false;
};

}  // namespace vdisp
