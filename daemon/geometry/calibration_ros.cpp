// calibration_ros.cpp: a ROS camera_info pair: left and right, each a YAML file with K, D, R and P of its camera.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/geometry/sheet.h"
#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

void read_camera(const Sheet& sheet, int i, StereoParts& parts) {
  const auto k = sheet.matrix<9>({"camera_matrix", "K"}, 3, 3);
  const auto rectification = sheet.matrix<9>({"rectification_matrix", "R"}, 3, 3);
  const auto projection = sheet.matrix<12>({"projection_matrix", "P"}, 3, 4);
  if (!k || !rectification || !projection)
    refuse(sheet.file(), "is incomplete; needed are camera_matrix, rectification_matrix and projection_matrix");
  if ((*k)[0] == 0) refuse(sheet.file(), "camera_matrix is 0: the camera is not calibrated; needed is a calibrated pair");
  const std::string model = sheet.word({"distortion_model"});
  if (model != "" && model != "plumb_bob" && model != "rational_polynomial")
    refuse(sheet.file(), "distortion_model is '" + model + "', needed is plumb_bob or rational_polynomial");
  parts.k[i] = k;
  parts.distortion[i] = sheet.distortion({"distortion_coefficients", "D"}).value_or(std::array<double, 8>{});
  parts.rectification[i] = rectification;
  parts.projection[i] = projection;
}

/// Rectifying would change nothing: no distortion, no rotation, and the projection is the camera's own.
bool is_rectified(const StereoParts& parts, int i) {
  const auto &k = *parts.k[i], &r = *parts.rectification[i];
  const auto& p = *parts.projection[i];
  const auto& d = *parts.distortion[i];
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (k[3 * row + column] != p[4 * row + column] || r[3 * row + column] != (row == column)) return false;
  return std::all_of(d.begin(), d.end(), [](double value) { return value == 0; });
}

}  // namespace

StereoParts parse_ros(const std::array<NamedText, 2>& texts) {
  StereoParts parts;
  parts.format = "ROS camera_info";
  std::optional<std::array<int, 2>> sizes[2];
  for (int i : {0, 1}) {
    const Sheet sheet(texts[i].file, texts[i].content);
    sizes[i] = sheet.image_size();
    if (!sizes[i]) refuse(sheet.file(), "has no image_width and image_height; needed are both");
    read_camera(sheet, i, parts);
  }
  if (sizes[0] != sizes[1]) refuse(texts[1].file, "its image size differs from the left camera's; needed is one");
  parts.size = sizes[0];
  parts.images_are_rectified = is_rectified(parts, 0) && is_rectified(parts, 1);
  return parts;
}

}  // namespace vdisp::calibration
