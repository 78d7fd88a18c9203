// source.cpp: the source that [image source] source names.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/source.h"

#include <sysexits.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "daemon/sources/aravis.h"
#include "daemon/sources/dc1394.h"
#include "daemon/sources/files.h"
#include "daemon/sources/live.h"
#include "daemon/sources/sim.h"
#include "daemon/sources/v4l2.h"

namespace vdisp {
namespace {

struct SourceKind {
  std::string_view word;
  std::unique_ptr<StereoSource> (*open)(const Config&);
  /// What `source = auto` can find of it: cameras, in words; null: nothing is attached, it is asked for by its word.
  std::vector<std::string> (*attached)() = nullptr;
};

std::unique_ptr<StereoSource> open_dc1394(const Config& config) { return open_live(config, dc1394_cameras(config)); }

std::unique_ptr<StereoSource> open_v4l2(const Config& config) { return open_live(config, v4l2_cameras(config, v4l2_system())); }

std::vector<std::string> attached_to_v4l2() {
  std::vector<std::string> names;
  for (const V4l2Device& device : find_v4l2(v4l2_system())) names.push_back(device.text());
  return names;
}

constexpr SourceKind kinds[] = {
    {"files", open_files},
    {"sim", open_sim},
    {"aravis", open_aravis, attached_to_aravis},
    {"dc1394", open_dc1394, find_dc1394},
    {"v4l2", open_v4l2, attached_to_v4l2},
};

/// What looks like a camera to the kernel.
std::vector<std::string> camera_devices() {
  std::vector<std::string> found;
  std::error_code error;
  for (std::filesystem::directory_iterator i("/dev", error), end; !error && i != end; i.increment(error)) {
    const std::string name = i->path().filename().string();
    for (const std::string_view kind : {"video", "fw"})
      if (name.starts_with(kind) && name.size() > kind.size() && name.find_first_not_of("0123456789", kind.size()) == std::string::npos)
        found.push_back(i->path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

/// The one kind of which as many cameras are attached as are needed, or at least so many where they are named.
std::unique_ptr<StereoSource> open_attached(const Config& config) {
  const size_t needed = config.camera.views == "one" ? 2 : 1;
  const bool named = !config.camera.left.empty() || !config.camera.right.empty();
  std::vector<const SourceKind*> fit;
  std::vector<std::string> seen;
  for (const SourceKind& kind : kinds) {
    if (!kind.attached) continue;
    const std::vector<std::string> cameras = kind.attached();
    for (const std::string& camera : cameras) seen.push_back(camera + " (source = " + std::string(kind.word) + ")");
    if (cameras.size() == needed || (named && cameras.size() > needed)) fit.push_back(&kind);
  }
  if (fit.size() == 1) return fit.front()->open(config);
  if (seen.empty()) seen = camera_devices();
  throw SourceError(
      EX_UNAVAILABLE,
      "[image source] source = auto: " +
          (fit.empty()
               ? "needed " + std::string(needed == 2 ? "are two cameras, or one that gives both views ([camera] views)" : "is one camera")
               : std::string("more than one pair is attached; name the source, and [camera] left and right")) +
          "; found: " + (seen.empty() ? "no GigE or USB3 camera, no /dev/video* and no /dev/fw*" : joined(seen)) +
          "; use --sim for the simulator, or source = files for a recording");
}

}  // namespace

std::unique_ptr<StereoSource> open_source(const Config& config) {
  const std::string& word = config.image_source.source;
  for (const SourceKind& kind : kinds)
    if (kind.word == word) return kind.open(config);
  if (word == "auto") return open_attached(config);
  throw SourceError(EX_UNAVAILABLE, "[image source] source = " + word + ": this build has no driver for it");
}

}  // namespace vdisp
