// calibration.h: what a calibration file says of a stereo camera, whatever its format.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "daemon/geometry/frames.h"

namespace vdisp {

/// One camera as it is: pinhole with distortion, and how rectification turns it.
struct RawCamera {
  std::array<double, 9> k{};              ///< row-major 3x3, px
  std::array<double, 8> distortion{};     ///< OpenCV order: k1 k2 p1 p2 k3 k4 k5 k6
  std::array<double, 9> rectification{};  ///< row-major 3x3: raw camera frame to rectified camera frame
  std::array<double, 12> projection{};    ///< row-major 3x4 of the rectified view, px and px*m
};

struct Calibration {
  int width = 0, height = 0;                    ///< of the images it was made for; 0: the file does not say
  StereoView view;                              ///< the rectified pair
  std::optional<std::array<RawCamera, 2>> raw;  ///< left, right; absent: images are taken as rectified already
  std::string format;                           ///< what the file was: "SVS 3.2", "OpenCV", ...
  uint64_t hash = 0;                            ///< of all numbers above; equal calibrations have equal hashes
};

/// One line: file, what was found, what would be right.
class CalibrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where a file describes several pairs, which one is meant. Without effect on files that know one pair only.
struct ReadingOptions {
  bool colour = false;       ///< KITTI: cameras 2 and 3 instead of 0 and 1
  bool unrectified = false;  ///< KITTI calib_cam_to_cam, SVS with `rectified 1`: of the images before they were rectified
};

/// Reads a calibration of any known format, told by its content: OpenCV YAML/XML with P1, P2 (rectified) or K, D, R, T;
/// SVS .ini from v2.1 on; KITTI's calib.txt and calib_cam_to_cam.txt; a EuRoC folder or one of its sensor.yaml pair; a folder with the ROS
/// camera_info left.yaml and right.yaml, or one of such a pair. Throws CalibrationError for a file that is missing, unreadable, of no known
/// format, incomplete or contradictory (f <= 0, no baseline, right camera left of the left one).
Calibration read_calibration(const std::filesystem::path& path, const ReadingOptions& options = {});
/// The same of a text that is a whole calibration by itself: all formats but EuRoC and ROS. `name` is for messages.
Calibration parse_calibration(const std::string& name, const std::string& text);

}  // namespace vdisp
