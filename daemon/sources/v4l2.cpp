// v4l2.cpp: which devices.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/v4l2.h"

#include <linux/videodev2.h>
#include <sysexits.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <system_error>

#include "daemon/sources/source.h"
#include "daemon/sources/v4l2_camera.h"

namespace vdisp {
namespace {

template <size_t n>
std::string text_of(const uint8_t (&bytes)[n]) {
  const auto* text = reinterpret_cast<const char*>(bytes);
  return {text, strnlen(text, n)};
}

/// What may not be opened; empty: nothing.
std::string denied(V4l2System& system) {
  for (const std::string& path : system.devices()) {
    const int file = system.open(path.c_str());
    if (file >= 0)
      system.close(file);
    else if (errno == EACCES || errno == EPERM)
      return "no permission for " + path + "; the user of vdispd must be in the group of the device, which is video on Debian";
  }
  return {};
}

}  // namespace

std::vector<V4l2Device> find_v4l2(V4l2System& system) {
  std::vector<V4l2Device> found;
  for (const std::string& path : system.devices()) {
    const int file = system.open(path.c_str());
    if (file < 0) continue;
    v4l2_capability capability{};
    if (system.control(file, VIDIOC_QUERYCAP, &capability) == 0) {
      const uint32_t caps = capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
      if ((caps & V4L2_CAP_VIDEO_CAPTURE) && (caps & V4L2_CAP_STREAMING))
        found.push_back({path, text_of(capability.card), text_of(capability.bus_info)});
    }
    system.close(file);
  }
  return found;
}

std::vector<std::unique_ptr<Camera>> v4l2_cameras(const Config& config, V4l2System& system) {
  const camera_section& wanted = config.camera;
  if (wanted.trigger != "free")
    throw SourceError(EX_CONFIG, "[camera] trigger = " + wanted.trigger + ": V4L2 knows no triggers; needed is free");
  if (wanted.views == "turns") throw SourceError(EX_CONFIG, "[camera] views = turns is for source = dc1394; V4L2 takes one and beside");
  const size_t needed = wanted.views == "beside" ? 1 : 2;
  std::vector<std::string> names{wanted.left, wanted.right};
  names.resize(needed);
  if (needed == 1 && !wanted.right.empty())
    throw SourceError(EX_CONFIG, "[camera] right = " + wanted.right + ", with views = beside there is one camera, left");
  // Links lead to devices.
  std::set<std::string> taken;
  for (const std::string& name : names)
    if (std::error_code error; !name.empty() && !taken.insert(std::filesystem::weakly_canonical(name, error).string()).second)
      throw SourceError(EX_CONFIG, "[camera] left and right are both " + name + "; needed are two, or views = beside");
  std::string seen;
  std::vector<V4l2Device> attached;
  for (const std::string& name : names)
    if (name.empty() && attached.empty()) attached = find_v4l2(system);
  for (const V4l2Device& device : attached) seen += (seen.empty() ? "" : ", ") + device.text();
  std::vector<std::unique_ptr<Camera>> cameras;
  for (std::string& name : names) {
    for (const V4l2Device& device : attached)
      if (name.empty() && taken.insert(device.path).second) name = device.path;
    if (const std::string why = name.empty() ? denied(system) : std::string(); !why.empty())
      throw SourceError(EX_NOPERM, "[image source] source = v4l2: " + why);
    if (name.empty())
      throw SourceError(EX_UNAVAILABLE, "[image source] source = v4l2: " + std::to_string(needed) +
                                            (needed == 1 ? " camera is" : " cameras are") + " needed, there " +
                                            (seen.empty() ? "is none" : "is " + seen) +
                                            "; name what is to be waited for in [camera] left and right");
    cameras.push_back(std::make_unique<V4l2Camera>(system, name, config));
  }
  return cameras;
}

}  // namespace vdisp
