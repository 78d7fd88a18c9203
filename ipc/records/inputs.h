// inputs.h: what came in by the control socket: odometry, IMU, orders, events.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// Why a message of the control socket was refused.
enum class Refusal : uint32_t {
  none = 0,
  not_finite,    ///< NaN or infinite where a number is needed
  out_of_range,  ///< no rover does that: see docs/control.md
  backwards,     ///< not newer than what was accepted before
  late,          ///< older than [control] maxAge
  ahead,         ///< from the future: the sender's clock is not CLOCK_MONOTONIC
  jump,          ///< farther from the sample before than [control] maxSpeed and maxTurn allow
  other_sender,  ///< another process sends the same already
  recorded,      ///< the recording or the simulator tells it
  count
};

/// What became of the messages of one kind. Counts are since the start of the daemon.
struct InputTally {
  uint64_t accepted, refused;
  Refusal last_refusal;  ///< none: nothing was refused yet
  uint32_t in_step;      ///< accepted since the step before
};

/// `in/odometry`: the newest accepted odometry. REP-103 odometry frame: x forward, y left, z up at its start; NaN: not told.
/// Of a blind image, too, the record can be read: its tally says why nothing is there.
struct Odometry {
  static constexpr RecordType type = RecordType::odometry;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;                      ///< of the measurement, CLOCK_MONOTONIC; of a recording: of its frame
  double age_s;                              ///< at the start of this step; 0 of a recording and of the simulator
  double x, y, z;                            ///< m
  double roll, pitch, yaw;                   ///< rad; positive: right side low, nose down, to the left
  double speed, turn_rate;                   ///< m/s ahead, rad/s to the left
  double position_deviation, yaw_deviation;  ///< standard deviations, m and rad
  uint32_t frame;                            ///< changes when the odometry began anew elsewhere: what was fused before is void
  uint32_t unused;
  InputTally tally;
};

/// `in/imu`: the newest accepted sample, in the rover frame r.
struct Imu {
  static constexpr RecordType type = RecordType::imu;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;
  double age_s;
  double acceleration[3];  ///< m/s^2; at rest it points up
  double rate[3];          ///< rad/s; NaN: not measured
  double roll, pitch;      ///< rad, of the rover, if the acceleration is gravity alone; positive: right side low, nose down
  InputTally tally;
};

/// `in/drive`: what the rover was last told to do.
struct DriveOrder {
  static constexpr RecordType type = RecordType::drive;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  int64_t timestamp_ns;
  double age_s;
  double speed, turn_rate;  ///< m/s ahead, rad/s to the left
  InputTally tally;
};

/// Labels of events that the daemon itself understands: a recording begins, and every stage forgets what came before; the flight recorder
/// is to write what it holds: because somebody asks, and because the rover hit something (any label that begins so).
inline constexpr std::string_view recording_label = "recording", dump_flight_label = "dump-flight", bump_label = "bump";

/// `in/event`: the last events, newest first. tally.in_step tells how many are new; of more than `capacity` the oldest are lost.
struct Events {
  static constexpr RecordType type = RecordType::event;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 8;
  struct Entry {
    int64_t timestamp_ns;
    char label[48];
    /// The label, also where the zero at its end is missing.
    std::string_view text() const {
      const std::string_view whole(label, sizeof label);
      return whole.substr(0, whole.find('\0'));
    }
  };
  RecordHeader header;
  double age_s;  ///< of the newest
  uint32_t count, unused;
  Entry entries[capacity];
  InputTally tally;
};

static_assert(sizeof(Odometry) == 136 && sizeof(Imu) == 112 && sizeof(DriveOrder) == 64 && sizeof(Events) == 496);

/// One word for files, one phrase for people.
std::string_view name(Refusal refusal);
std::string_view describe(Refusal refusal);

}  // namespace vdisp
