// front_end.h: the daemon's own stages on recorded pairs, as far as the classifiers' features.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "daemon/snow/model.h"
#include "ipc/recording.h"

namespace vdisp::train {

/// For one recording: rectified by its calibration if it has one, scaled, smoothed, matched. One thread at a time.
class FrontEnd {
 public:
  /// Throws ToolError (78) where the recording does not fit the settings, RecordingError and CalibrationError.
  FrontEnd(const Recording& recording, const snow::Settings& settings);
  ~FrontEnd();
  /// Reads a pair and runs the stages. Throws RecordingError where a picture is damaged.
  void run(size_t pair);
  /// Of the pair that was run last, as many as the encoding's image has pixels.
  void features(snow::Encoding encoding, std::span<uint8_t> pixels) const;

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace vdisp::train
