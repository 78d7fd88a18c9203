// aravis.h: the source `aravis`: GigE Vision and USB3 Vision cameras, through Aravis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/sources/camera.h"
#include "daemon/sources/source.h"

namespace vdisp {

/// The cameras that [camera] names, or that are attached. Errors as open_live(). The configuration must outlive the source.
std::unique_ptr<StereoSource> open_aravis(const Config& config);

/// The cameras as open_aravis() makes them, closed: two, or one that gives both views. The configuration must outlive them.
std::vector<std::unique_ptr<Camera>> aravis_cameras(const Config& config);

/// What is attached, for messages and for `source = auto`: "GigE camera Aravis-Fake-LEFT01 at 127.0.0.1". Takes about a second.
std::vector<std::string> attached_to_aravis();

}  // namespace vdisp
