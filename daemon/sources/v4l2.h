// v4l2.h: USB and other cameras of the kernel's Video4Linux2, by mmap: two, or one that gives both views side by side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/sources/camera.h"
#include "daemon/sources/v4l2_system.h"

namespace vdisp {

/// What looks like a camera: device, name, and where it is attached: "/dev/video0 (HD Webcam, usb-0000:00:14.0-1)".
struct V4l2Device {
  std::string path, card, bus;
  std::string text() const { return path + " (" + card + ", " + bus + ")"; }
};
/// Devices that capture and stream. What cannot be opened is left out.
std::vector<V4l2Device> find_v4l2(V4l2System& system);

/// The cameras that [camera] left and right name, or those attached where they are empty. Throws SourceError 69 where none is named and too
/// few are attached, 78 for what V4L2 does not know (trigger, views = turns).
std::vector<std::unique_ptr<Camera>> v4l2_cameras(const Config& config, V4l2System& system);

}  // namespace vdisp
