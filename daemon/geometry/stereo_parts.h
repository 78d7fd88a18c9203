// stereo_parts.h: what a calibration file says, before it is checked and put together; inside this room only.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "daemon/geometry/calibration.h"

namespace vdisp::calibration {

/// In m and px, finite, matrices row-major and of the right size; unset where the file does not say. [0] is left, [1] right.
struct StereoParts {
  std::string format;
  std::optional<std::array<int, 2>> size;  ///< width, height
  std::optional<std::array<double, 9>> k[2];
  std::optional<std::array<double, 8>> distortion[2];
  std::optional<std::array<double, 9>> rotation;  ///< x_right = rotation x_left + translation
  std::optional<std::array<double, 3>> translation;
  std::optional<std::array<double, 9>> rectification[2];
  std::optional<std::array<double, 12>> projection[2];
  bool images_are_rectified = false;  ///< the file says that its images have been rectified already
};

/// A file's content; `file` names it in messages.
struct NamedText {
  std::string file, content;
};

StereoParts parse_opencv(const std::string& file, const std::string& text);
StereoParts parse_svs(const std::string& file, const std::string& text, const ReadingOptions& options);
StereoParts parse_kitti(const std::string& file, const std::string& text, const ReadingOptions& options);
/// Left and right: cam0/sensor.yaml and cam1/sensor.yaml; two camera_info.
StereoParts parse_euroc(const std::array<NamedText, 2>& texts);
StereoParts parse_ros(const std::array<NamedText, 2>& texts);

/// Reads the file, or the files that belong to it, and tells the format by the content.
StereoParts read_parts(const std::filesystem::path& path, const ReadingOptions& options);
/// Of a text that is a whole calibration by itself: all formats but EuRoC and ROS.
StereoParts parse_single(const std::string& file, const std::string& text, const ReadingOptions& options);
/// Checks the parts, rectifies where the file does not, and puts them together.
Calibration assemble(const std::string& file, StereoParts parts);
/// The same of what `parse` gives; all that it throws is made a CalibrationError, but for what is out of memory.
Calibration assemble_from(const std::string& file, const std::function<StereoParts()>& parse);

/// The text of a file of at most 1 MiB. Throws CalibrationError.
std::string read_text(const std::filesystem::path& path);
/// Throws CalibrationError "calibration FILE: WHAT".
[[noreturn]] void refuse(const std::string& file, const std::string& what);
/// Width and height as numbers of a file. Refused where no image can have them; check_size() in calibration.cpp looks closer.
std::array<int, 2> whole_size(const std::string& file, double width, double height);
/// A number for a message.
std::string text(double number);

}  // namespace vdisp::calibration
