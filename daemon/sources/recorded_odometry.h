// recorded_odometry.h: where the rover was, read from a file beside a recording.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "ipc/records.h"

namespace vdisp {

/// Two kinds of file. CSV: the first line names the columns x, y, yaw and timestamp_ns or frame, and maybe z, roll, pitch, speed,
/// turn_rate. KITTI's poses.txt: per line a 3x4 matrix, row by row, that takes the left camera's frame (x right, y down, z ahead) of
/// that pair to the first one's; [mounting] x, y and yaw make the rover's place of it.
class RecordedOdometry {
 public:
  /// Throws SourceError: 66 not readable, 78 not of these kinds, naming the line.
  explicit RecordedOdometry(const std::string& file);

  /// For pair `number` of the recording, taken at `timestamp_ns`; between two stamps it is interpolated where they are at most a second
  /// apart. x is NaN where the file does not tell.
  Odometry at(int64_t number, int64_t timestamp_ns, const mounting_section& mounting) const;

 private:
  void read_kitti(const std::string& file, const std::vector<std::string>& lines);
  void read_csv(const std::string& file, const std::vector<std::string>& lines);
  Odometry by_time(int64_t timestamp_ns) const;

  bool by_number_ = false, of_camera_ = false;
  std::vector<Odometry> poses_;  // timestamp_ns ascending; it is the pair's number where by_number_
};

}  // namespace vdisp
