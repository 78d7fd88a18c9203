// stage_run.h: recorded pairs through the daemon's own stages: raw and rectified views, and the floor of each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/calibration.h"
#include "daemon/sources/source.h"
#include "ipc/records.h"

namespace vdisp::calibrate {

/// What the stages made of one pair.
struct StagedPair {
  std::array<cv::Mat, 2> camera, rectified;  ///< left, right; gray8
  FloorModel floor{};
};

struct StageRun {
  std::optional<Calibration> calibration;
  std::vector<StagedPair> pairs;  ///< good ones
  int bad = 0;
};

/// At most `most` pairs of the source. Throws SourceError, CalibrationError, FormatError.
StageRun run_stages(std::unique_ptr<StereoSource> source, const Config& config, int most);

}  // namespace vdisp::calibrate
