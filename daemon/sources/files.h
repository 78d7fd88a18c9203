// files.h: the source `files`: recorded pairs from images or videos, each in order, none dropped.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/sources/source.h"

namespace vdisp {

/// Reads the calibration at once, the recording at open(). Throws CalibrationError; open() throws SourceError.
std::unique_ptr<StereoSource> open_files(const Config& config);

}  // namespace vdisp
