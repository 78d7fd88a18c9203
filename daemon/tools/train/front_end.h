// front_end.h: the daemon's own stages on recorded pairs, as far as the classifiers' features.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "daemon/snow/model.h"
#include "daemon/stages/machine.h"
#include "ipc/recording.h"

namespace vdisp::train {

/// For one recording: rectified by its calibration if it has one, made smaller by a whole number, smoothed, matched. One thread at a
/// time; machines may be shared if they have one thread.
class FrontEnd {
 public:
  /// Throws ToolError (66) where the recording's size is no multiple of the settings' or its vdisp.cfg is not understood, FormatError where
  /// the stages refuse it, RecordingError and CalibrationError.
  FrontEnd(const Recording& recording, const snow::Settings& settings, Machine& machine);
  ~FrontEnd();
  /// Reads a pair and runs the stages. Not none: the daemon would be blind with it, and there are no features. Throws RecordingError
  /// where a picture is damaged.
  Reason run(size_t pair);
  /// Of the pair that was run last, as many as the encoding's image has pixels.
  void features(snow::Encoding encoding, std::span<uint8_t> pixels) const;

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace vdisp::train
