// calibration_yaml.cpp: calibrations as OpenCV's FileStorage writes them (YAML, XML), and EuRoC's sensor.yaml.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/core.hpp>
#include <string>

#include "daemon/geometry/sheet.h"
#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

struct EurocCamera {
  cv::Matx44d body_from_camera;
  std::array<double, 9> k;
  std::array<double, 8> distortion;
  std::array<int, 2> size;
};

EurocCamera euroc_camera(const NamedText& text) {
  const Sheet sheet(text.file, text.content);
  const std::string model = sheet.word({"camera_model"}), lens = sheet.word({"distortion_model"});
  if (model != "pinhole") refuse(sheet.file(), "camera_model is '" + model + "', needed is pinhole");
  if (lens != "radial-tangential" && lens != "radtan")
    refuse(sheet.file(), "distortion_model is '" + lens + "', needed is radial-tangential");
  const auto pose = sheet.matrix<16>({"T_BS"}, 4, 4);
  const auto intrinsics = sheet.matrix<4>({"intrinsics"}, 4, 1);
  const auto distortion = sheet.distortion({"distortion_coefficients"});
  const auto size = sheet.matrix<2>({"resolution"}, 2, 1);
  if (!pose || !intrinsics || !distortion || !size)
    refuse(sheet.file(), "is incomplete; needed are T_BS, resolution, intrinsics and distortion_coefficients");
  const auto& [fx, fy, cx, cy] = *intrinsics;
  return {cv::Matx44d(pose->data()), {fx, 0, cx, 0, fy, cy, 0, 0, 1}, *distortion, whole_size(sheet.file(), (*size)[0], (*size)[1])};
}

}  // namespace

StereoParts parse_opencv(const std::string& file, const std::string& content) {
  const Sheet sheet(file, content);
  StereoParts parts;
  parts.format = "OpenCV";
  parts.size = sheet.image_size();
  parts.k[0] = sheet.matrix<9>({"M1", "K1", "camera_matrix_1", "cameraMatrix1"}, 3, 3);
  parts.k[1] = sheet.matrix<9>({"M2", "K2", "camera_matrix_2", "cameraMatrix2"}, 3, 3);
  parts.distortion[0] = sheet.distortion({"D1", "distortion_coefficients_1", "distCoeffs1"});
  parts.distortion[1] = sheet.distortion({"D2", "distortion_coefficients_2", "distCoeffs2"});
  parts.rotation = sheet.matrix<9>({"R", "rotation_matrix"}, 3, 3);
  parts.translation = sheet.matrix<3>({"T", "translation_coefficients", "translation_vector"}, 3, 1);
  parts.rectification[0] = sheet.matrix<9>({"R1"}, 3, 3);
  parts.rectification[1] = sheet.matrix<9>({"R2"}, 3, 3);
  parts.projection[0] = sheet.matrix<12>({"P1"}, 3, 4);
  parts.projection[1] = sheet.matrix<12>({"P2"}, 3, 4);
  return parts;
}

StereoParts parse_euroc(const std::array<NamedText, 2>& texts) {
  const EurocCamera left = euroc_camera(texts[0]), right = euroc_camera(texts[1]);
  if (left.size != right.size) refuse(texts[1].file, "its resolution differs from cam0's; needed is one");
  const cv::Matx44d right_from_left = right.body_from_camera.inv() * left.body_from_camera;
  StereoParts parts;
  parts.format = "EuRoC";
  parts.size = left.size;
  parts.k[0] = left.k;
  parts.k[1] = right.k;
  parts.distortion[0] = left.distortion;
  parts.distortion[1] = right.distortion;
  auto& rotation = parts.rotation.emplace();
  auto& translation = parts.translation.emplace();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation[3 * i + j] = right_from_left(i, j);
    translation[i] = right_from_left(i, 3);
  }
  return parts;
}

}  // namespace vdisp::calibration
