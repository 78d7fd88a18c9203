// calibration_write.h: a calibration as the text of a file: OpenCV, SVS, ROS.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "daemon/geometry/calibration.h"

namespace vdisp {

enum class CalibrationFormat { opencv, svs, ros };

struct CalibrationFile {
  std::string name;  ///< in the folder of a pair: left.yaml, right.yaml; empty where one file is all
  std::string content;
};

/// What read_calibration() reads back to the same numbers, but for rounding (1e-9 of each). OpenCV: M1 D1 M2 D2 R T R1 R2 P1 P2, or P1 P2
/// of rectified images; SVS 4.0, in mm; ROS: left.yaml and right.yaml. Throws CalibrationError where the format cannot hold it: SVS knows
/// no k4 to k6 and no skew, ROS needs the image size, a camera that is not rectified as well.
std::vector<CalibrationFile> calibration_texts(const Calibration& calibration, CalibrationFormat format);

/// Where the right camera stands seen from the left: x_right = rotation x_left + translation (m).
struct Stand {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<double, 3> translation{};
};
Stand stand_of(const Calibration& calibration);

/// P1 or P2 of the rectified pair; side 0 is left.
std::array<double, 12> projection_of(const Calibration& calibration, int side);

/// A calibration of cameras as solve() finds them: K and D of both, R and T; rectified with equal cx and no black borders.
/// Throws CalibrationError where these contradict each other.
Calibration make_calibration(int width, int height, const std::array<RawCamera, 2>& cameras, const Stand& stand);

}  // namespace vdisp
