// republish.cpp: the newest samples as records, once a step.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/republish.h"

#include <cmath>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

/// In lock-step with the frames: the same from run to run.
template <class Record>
void show(const Record& recorded, Image& image) {
  Record& record = *image.row<Record>(0);
  const RecordHeader header = record.header;
  const InputTally tally = record.tally;
  record = recorded;
  record.header = header;
  record.tally = tally;
  image.timestamp_ns = recorded.timestamp_ns;
  image.flags |= flag_synthetic;
  image.state = ImageState::valid;
  image.reason = Reason::none;
}

/// As it was then, blind or not.
template <class Record>
void show(const RecordedInput<Record>& recorded, Image& image) {
  *image.row<Record>(0) = recorded.record;
  image.timestamp_ns = recorded.timestamp_ns;
  image.flags |= recorded.flags;
  if (recorded.reason != Reason::none) image.set_blind(recorded.reason);
}

}  // namespace

std::vector<ImageSpec> Republish::check(std::span<const ImageSpec> in) {
  if (!in.empty()) throw FormatError("takes no input, was given " + std::to_string(in.size()));
  if (odometry_()) inputs_.refuse_odometry();
  if (imu_()) inputs_.refuse_imu();
  if (recorded_()) inputs_.refuse_all();
  return {record_spec<Odometry>(), record_spec<Imu>(), record_spec<DriveOrder>(), record_spec<Events>()};
}

Outcome Republish::process(std::span<const Image* const>, std::span<Image* const> out) noexcept {
  if (const RecordedStep* recorded = recorded_()) {
    show(recorded->odometry, *out[0]);
    show(recorded->imu, *out[1]);
    show(recorded->drive, *out[2]);
    show(recorded->event, *out[3]);
    return Outcome::valid;
  }
  const int64_t now = monotonic_ns();
  inputs_.write_odometry(*out[0], now);
  inputs_.write_imu(*out[1], now);
  inputs_.write_drive(*out[2], now);
  inputs_.write_events(*out[3], now);
  if (const Odometry* recorded = odometry_()) {
    show(*recorded, *out[0]);
    if (std::isnan(recorded->x)) out[0]->set_blind(Reason::no_odometry);
  }
  if (const Imu* recorded = imu_()) show(*recorded, *out[1]);
  return Outcome::valid;
}

}  // namespace vdisp
