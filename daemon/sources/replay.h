// replay.h: the source `files` where it is given a recording: each step as the tree saw it then, blind ones too.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/sources/source.h"

namespace vdisp {

/// Reads and checks [image source] recording at once. Throws SourceError and CalibrationError.
std::unique_ptr<StereoSource> open_replay(const Config& config);

}  // namespace vdisp
