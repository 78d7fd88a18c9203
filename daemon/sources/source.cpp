// source.cpp: the source that [image source] source names.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/source.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "daemon/sources/dc1394.h"
#include "daemon/sources/files.h"
#include "daemon/sources/live.h"
#include "daemon/sources/sim.h"
#include "daemon/sources/v4l2.h"

namespace vdisp {
namespace {

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

[[noreturn]] void refuse_auto() {
  std::string seen;
  for (const std::string& device : camera_devices()) seen += (seen.empty() ? "" : ", ") + device;
  throw SourceError(69, "[image source] source = auto: no camera that this build can drive (it has no camera drivers); " +
                            (seen.empty() ? "there is no /dev/video* and no /dev/fw*" : "there is " + seen) +
                            "; use --sim for the simulator, or source = files for a recording");
}

}  // namespace

std::unique_ptr<StereoSource> open_source(const Config& config) {
  const std::string& kind = config.image_source.source;
  if (kind == "files") return open_files(config);
  if (kind == "sim") return open_sim(config);
  if (kind == "dc1394") return open_live(config, dc1394_cameras(config));
  if (kind == "v4l2") return open_live(config, v4l2_cameras(config, v4l2_system()));
  refuse_auto();
}

}  // namespace vdisp
