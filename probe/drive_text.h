// drive_text.h: what is decided, and how the rover is driven, in words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

/// SnowScores, Decision, DriveCommand and CrossCheck as lines; none for anything else.
std::vector<std::string> drive_text(const Image& image);

}  // namespace vdisp
