// calibration_report.h: the stage that shows the calibration as a text, so that a recorder elsewhere can keep it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "daemon/core/processor.h"
#include "daemon/geometry/calibration_write.h"
#include "ipc/records.h"

namespace vdisp {

/// No input, one record, the same in each frame. One that is too long for its record is never shown: blind, no_calibration.
class CalibrationReport final : public ImageProcessor {
 public:
  explicit CalibrationReport(const Calibration& calibration)
      : hash_(calibration.hash), text_(calibration_texts(calibration, CalibrationFormat::opencv)[0].content) {}

  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<CalibrationText>()}; }
  Outcome process(std::span<const Image* const>, std::span<Image* const> out) noexcept override {
    CalibrationText& record = make_record<CalibrationText>(*out[0]);
    out[0]->calibration_hash = record.hash = hash_;
    if (text_.size() > sizeof record.text) {
      out[0]->set_blind(Reason::no_calibration);
      return Outcome::valid;
    }
    record.size = static_cast<uint32_t>(text_.size());
    std::memcpy(record.text, text_.data(), text_.size());
    return Outcome::valid;
  }

 private:
  uint64_t hash_;
  std::string text_;
};

}  // namespace vdisp
