// robot_track.cpp: lines of track.csv and world.csv.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/robot_track.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include "daemon/sources/source.h"

namespace vdisp {

RobotTrack::File RobotTrack::make(const std::filesystem::path& path) {
  File file(std::fopen(path.c_str(), "we"));
  if (!file) throw SourceError(73, "[sim] track: cannot write " + path.string() + ": " + std::strerror(errno));
  return file;
}

RobotTrack::RobotTrack(const std::filesystem::path& folder, const std::vector<sim::WorldOutline>& world) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw SourceError(73, "[sim] track: cannot make the folder " + folder.string() + ": " + error.message());
  const File outlines = make(folder / "world.csv");
  std::fputs("what,corners\n", outlines.get());
  for (const sim::WorldOutline& outline : world) {
    std::fputs(outline.what, outlines.get());
    for (const auto& corner : outline.corners) std::fprintf(outlines.get(), ",%.3f,%.3f", corner[0], corner[1]);
    std::fputs("\n", outlines.get());
  }
  file_ = make(folder / "track.csv");
  std::fputs("time_s,x,y,yaw,speed,turn_rate,steering,expert,clearance,travelled,collision,stuck,met\n", file_.get());
}

void RobotTrack::add(double time_s, const sim::RobotReport& r, std::string_view ordered) noexcept {
  if (failed_) return;
  const std::string_view expert = name(r.steering);
  std::fprintf(file_.get(), "%.4f,%.4f,%.4f,%.5f,%.4f,%.4f,%.*s,%.*s,%.4f,%.3f,%d,%d,%s\n", time_s, r.x, r.y, r.yaw, r.speed, r.turn_rate,
               static_cast<int>(ordered.size()), ordered.data(), static_cast<int>(expert.size()), expert.data(), r.clearance, r.travelled,
               r.collided, r.stuck, r.collided && r.met ? r.met : "");
  failed_ = std::ferror(file_.get()) != 0;
}

}  // namespace vdisp
