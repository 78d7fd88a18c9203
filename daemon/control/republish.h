// republish.h: the stage that shows the tree what came in: in/odometry, in/imu, in/drive, in/event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "daemon/control/inputs.h"
#include "daemon/core/processor.h"
#include "ipc/recorded_step.h"

namespace vdisp {

inline constexpr const char* input_topics[] = {"in/odometry", "in/imu", "in/drive", "in/event"};

/// No input, four records. It never makes a step blind: what is missing is blind itself.
/// Images carry the time of the newest sample, not of the frame.
class Republish final : public ImageProcessor {
 public:
  /// What the source knows of the pair at hand; null: this source tells none of it, the socket may.
  using RecordedOdometry = std::function<const Odometry*()>;
  using RecordedImu = std::function<const Imu*()>;
  /// All that came in when the frame at hand was recorded; null: no recording tells it.
  using RecordedInputs = std::function<const RecordedStep*()>;
  Republish(
      Inputs& inputs, RecordedOdometry odometry, RecordedImu imu, RecordedInputs recorded = [] { return nullptr; })
      : inputs_(inputs), odometry_(std::move(odometry)), imu_(std::move(imu)), recorded_(std::move(recorded)) {}

  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  Inputs& inputs_;
  RecordedOdometry odometry_;
  RecordedImu imu_;
  RecordedInputs recorded_;
};

}  // namespace vdisp
