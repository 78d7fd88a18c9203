// camera_report.h: the stage that shows what the cameras deliver: camera/status.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "daemon/core/processor.h"
#include "daemon/sources/source.h"

namespace vdisp {

/// No input, one record; never blind, as it is read most when the cameras are.
class CameraReport final : public ImageProcessor {
 public:
  /// The source must outlive the stage, and have cameras().
  explicit CameraReport(const StereoSource& source) : source_(source) {}

  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<CameraStatus>()}; }
  Outcome process(std::span<const Image* const>, std::span<Image* const> out) noexcept override {
    CameraStatus& record = make_record<CameraStatus>(*out[0]);
    const RecordHeader header = record.header;
    record = *source_.cameras();
    record.header = header;
    return Outcome::valid;
  }

 private:
  const StereoSource& source_;
};

}  // namespace vdisp
