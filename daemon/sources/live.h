// live.h: cameras as a stereo source: what the drivers have in common.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "daemon/sources/camera.h"
#include "daemon/sources/source.h"

namespace vdisp {

/// One camera that gives both views, or left and right. Opens them at once and waits some seconds for the first time; a camera that is
/// not there then is looked for as long as the daemon runs, and the size of the images is that of [image source] width and height, of
/// the calibration, or 640x480. Throws SourceError (77 no permission, 78 what the camera cannot give) and CalibrationError. The
/// configuration must outlive the source.
std::unique_ptr<StereoSource> open_live(const Config& config, std::vector<std::unique_ptr<Camera>> cameras);

}  // namespace vdisp
