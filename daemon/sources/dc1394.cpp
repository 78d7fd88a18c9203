// dc1394.cpp: which cameras on the bus.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/dc1394.h"

#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "daemon/sources/dc1394_camera.h"
#include "daemon/sources/source.h"

namespace vdisp {
namespace {

uint64_t guid_of(const std::string& text, const char* key) {
  char* end = nullptr;
  const uint64_t guid = std::strtoull(text.c_str(), &end, 16);
  if (text.empty() || *end != '\0' || guid == 0)
    throw SourceError(EX_CONFIG, "[camera] " + std::string(key) + " = " + text +
                                     " is no GUID of a FireWire camera; needed are up to 16 hexadecimal digits");
  return guid;
}

}  // namespace

Dc1394Bus open_dc1394_bus() {
  // What it would print is in the faults.
  for (const dc1394log_t kind : {DC1394_LOG_ERROR, DC1394_LOG_WARNING, DC1394_LOG_DEBUG})
    dc1394_log_register_handler(
        kind, [](dc1394log_t, const char*, void*) {}, nullptr);
  return Dc1394Bus(dc1394_new());
}

std::string guid_text(uint64_t guid) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(guid));
  return text;
}

std::string dc1394_denied() {
  std::error_code error;
  for (std::filesystem::directory_iterator i("/dev", error), end; !error && i != end; i.increment(error)) {
    const std::string path = i->path().string();
    if (path.starts_with("/dev/fw") && access(path.c_str(), R_OK | W_OK) != 0)
      return "no permission for " + path + "; the user of vdispd must be in its group (video, by the rules for cameras)";
  }
  return {};
}

std::vector<std::string> find_dc1394() {
  std::vector<std::string> found;
  const Dc1394Bus bus = open_dc1394_bus();
  dc1394camera_list_t* list = nullptr;
  if (!bus || dc1394_camera_enumerate(bus.get(), &list) != DC1394_SUCCESS) return found;
  for (uint32_t i = 0; i < list->num; ++i) found.push_back(guid_text(list->ids[i].guid));
  dc1394_camera_free_list(list);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::unique_ptr<Camera>> dc1394_cameras(const Config& config) {
  const camera_section& wanted = config.camera;
  const size_t needed = wanted.views == "one" ? 2 : 1;
  if (wanted.views == "beside") throw SourceError(EX_CONFIG, "[camera] views = beside is for v4l2 and aravis; dc1394 takes one and turns");
  if (needed == 2 && wanted.pairing == "count")
    throw SourceError(EX_CONFIG, "[camera] pairing = count: FireWire frames carry no number; needed is time");
  if (needed == 1 && !wanted.right.empty())
    throw SourceError(EX_CONFIG, "[camera] right = " + wanted.right + ", with views = turns there is one camera, left");
  std::vector<std::unique_ptr<Camera>> cameras;
  if (!wanted.left.empty() && (needed == 1 || !wanted.right.empty())) {
    cameras.push_back(std::make_unique<Dc1394Camera>(guid_of(wanted.left, "left"), config));
    if (needed == 2) cameras.push_back(std::make_unique<Dc1394Camera>(guid_of(wanted.right, "right"), config));
    return cameras;
  }
  std::vector<std::string> attached = find_dc1394();
  std::string seen;
  for (const std::string& guid : attached) seen += (seen.empty() ? "" : ", ") + guid;
  if (attached.size() < needed) {
    if (const std::string denied = dc1394_denied(); !denied.empty())
      throw SourceError(EX_NOPERM, "[image source] source = dc1394: " + denied);
    throw SourceError(EX_UNAVAILABLE, "[image source] source = dc1394: " + std::to_string(needed) +
                                          (needed == 1 ? " camera is" : " cameras are") + " needed, on the bus there " +
                                          (seen.empty() ? "is none" : "is " + seen) +
                                          "; name what is to be waited for in [camera] left and right");
  }
  const auto take = [&](const std::string& name, const char* key) {
    const std::string guid = name.empty() ? attached.front() : guid_text(guid_of(name, key));
    attached.erase(std::remove(attached.begin(), attached.end(), guid), attached.end());
    cameras.push_back(std::make_unique<Dc1394Camera>(guid_of(guid, key), config));
  };
  // A camera that is named is not given to the other side.
  if (!wanted.right.empty())
    attached.erase(std::remove(attached.begin(), attached.end(), guid_text(guid_of(wanted.right, "right"))), attached.end());
  if (attached.empty())
    throw SourceError(EX_UNAVAILABLE, "[image source] source = dc1394: besides " + wanted.right + " there is no camera on the bus");
  take(wanted.left, "left");
  if (needed == 2) take(wanted.right, "right");
  return cameras;
}

}  // namespace vdisp
