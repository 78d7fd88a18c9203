// usb_vision.h: USB3 Vision cameras that are plugged in and may not be opened: libraries do not list those.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdisp {

/// Empty where there is none; else which, and what makes it right, in one line. The folders are for tests.
std::string unreadable_usb_cameras(const std::string& sys = "/sys/bus/usb/devices", const std::string& dev = "/dev/bus/usb");

}  // namespace vdisp
