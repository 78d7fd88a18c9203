// robot_track.h: the way of a simulated robot and the world around it, as two CSV files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "daemon/sim/simulator.h"

namespace vdisp {

/// Writes `world.csv` at once (a line for each thing: what it is, then its corners x, y) and a line of `track.csv` for each frame.
class RobotTrack {
 public:
  /// Throws SourceError 73 where a file cannot be made.
  RobotTrack(const std::filesystem::path& folder, const std::vector<sim::WorldOutline>& world);
  /// Not on the tree's thread: it writes to a file. `ordered`: what the robot was told, one word.
  void add(double time_s, const sim::RobotReport& report, std::string_view ordered) noexcept;
  /// Something could not be written; from then on nothing is.
  bool failed() const { return failed_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Close>;
  static File make(const std::filesystem::path& path);
  File file_;
  std::atomic<bool> failed_ = false;
};

}  // namespace vdisp
