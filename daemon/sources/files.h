// files.h: the source `files`: recorded pairs from images or videos, each in order, none dropped.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/sources/source.h"

namespace vdisp {

/// Reads calibration and odometry at once, the recording at open(). Throws CalibrationError and SourceError; open() SourceError.
/// The configuration must outlive the source.
std::unique_ptr<StereoSource> open_files(const Config& config);

}  // namespace vdisp
