// dc1394.h: FireWire cameras (IIDC): the STH-MDCS2 with both views in one frame, or two cameras.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/sources/camera.h"

namespace vdisp {

/// GUIDs of the cameras on the bus, 16 hexadecimal digits, sorted.
std::vector<std::string> find_dc1394();

/// The cameras that [camera] left and right name by GUID, or those attached where they are empty. Throws SourceError 69 where none is named
/// and too few are attached, 77 where the bus may not be opened, 78 for a GUID that is none.
std::vector<std::unique_ptr<Camera>> dc1394_cameras(const Config& config);

}  // namespace vdisp
