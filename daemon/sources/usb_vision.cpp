// usb_vision.cpp: the kernel's own list of interfaces against the rights on its device files.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/usb_vision.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace vdisp {
namespace {

namespace fs = std::filesystem;

std::string line_of(const fs::path& file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

int number_of(const fs::path& file) { return std::atoi(line_of(file).c_str()); }

}  // namespace

std::string unreadable_usb_cameras(const std::string& sys, const std::string& dev) {
  std::error_code error;
  for (fs::directory_iterator i(sys, error), end; !error && i != end; i.increment(error)) {
    // USB3 Vision 1.0: class 0xEF (miscellaneous), subclass 5, protocol 0 is the control interface.
    const fs::path interface = i->path();
    if (line_of(interface / "bInterfaceClass") != "ef" || line_of(interface / "bInterfaceSubClass") != "05" ||
        line_of(interface / "bInterfaceProtocol") != "00")
      continue;
    const std::string name = interface.filename().string();  // 2-1:1.0, of device 2-1
    const fs::path device = interface.parent_path() / name.substr(0, name.find(':'));
    char node[32];
    std::snprintf(node, sizeof node, "/%03d/%03d", number_of(device / "busnum"), number_of(device / "devnum"));
    if (access((dev + node).c_str(), R_OK | W_OK) == 0 || access((dev + node).c_str(), F_OK) != 0) continue;
    return "USB3 camera '" + line_of(device / "product") + "' is plugged in, and " + dev + node +
           " may not be opened: a udev rule must give it to a group of this user (docs/cameras.md)";
  }
  return {};
}

}  // namespace vdisp
