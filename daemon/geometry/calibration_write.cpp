// calibration_write.cpp: writes calibrations: OpenCV YAML, SVS .ini, a ROS camera_info pair.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/geometry/calibration_write.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <span>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp {
namespace {

/// As many digits as it takes to read the same number back; a real in YAML of all versions.
std::string number(double value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value + 0.0).ptr;
  std::string digits(buffer, end);
  if (digits.find('.') == std::string::npos) digits.insert(std::min(digits.find('e'), digits.size()), ".0");
  return digits;
}

std::string joined(std::span<const double> values, const char* between) {
  std::string line;
  for (double value : values) line += (line.empty() ? "" : between) + number(value);
  return line;
}

bool rational(const RawCamera& camera) {
  return std::any_of(camera.distortion.begin() + 5, camera.distortion.end(), [](double value) { return value != 0; });
}
std::span<const double> coefficients(const RawCamera& camera) { return {camera.distortion.data(), rational(camera) ? 8u : 5u}; }

std::string opencv_matrix(const std::string& name, int rows, int cols, std::span<const double> values) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) + "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [ " +
         joined(values, ", ") + " ]\n";
}

std::string opencv_text(const Calibration& c) {
  std::string text = "%YAML:1.0\n---\n";
  if (c.width) text += "image_width: " + std::to_string(c.width) + "\nimage_height: " + std::to_string(c.height) + "\n";
  if (c.raw) {
    for (int i : {0, 1}) {
      const RawCamera& camera = (*c.raw)[i];
      const std::string digit = std::to_string(i + 1);
      text += opencv_matrix("M" + digit, 3, 3, camera.k);
      text += opencv_matrix("D" + digit, 1, static_cast<int>(coefficients(camera).size()), coefficients(camera));
    }
    const Stand stand = stand_of(c);
    text += opencv_matrix("R", 3, 3, stand.rotation) + opencv_matrix("T", 3, 1, stand.translation);
    text += opencv_matrix("R1", 3, 3, (*c.raw)[0].rectification) + opencv_matrix("R2", 3, 3, (*c.raw)[1].rectification);
  }
  return text + opencv_matrix("P1", 3, 4, projection_of(c, 0)) + opencv_matrix("P2", 3, 4, projection_of(c, 1));
}

std::string rows_of(const std::string& name, std::span<const double> values, size_t columns) {
  std::string text = name + "\n";
  for (size_t at = 0; at < values.size(); at += columns) text += joined(values.subspan(at, columns), " ") + "\n";
  return text;
}

/// Of rectified images the camera is what the projection says.
RawCamera camera_of(const Calibration& c, int side) {
  if (c.raw) return (*c.raw)[side];
  const auto p = projection_of(c, side);
  return {{p[0], 0, p[2], 0, p[5], p[6], 0, 0, 1}, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, p};
}

std::string svs_camera(const Calibration& c, int side) {
  const RawCamera camera = camera_of(c, side);
  if (rational(camera))
    throw CalibrationError(
        "SVS files hold k1, k2, k3 and two tangential coefficients, and these cameras have k4 to k6; needed is another "
        "format, opencv or ros");
  if (camera.k[1] != 0) throw CalibrationError("SVS files hold no skew, and these cameras have some; needed is another format");
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = camera.distortion;
  const auto line = [](const char* key, double value) { return std::string(key) + " " + number(value) + "\n"; };
  std::string text = side == 0 ? "\n[left camera]\n" : "\n[right camera]\n";
  if (c.width) text += "pwidth " + std::to_string(c.width) + "\npheight " + std::to_string(c.height) + "\n";
  text += line("sx", 1) + line("Cx", camera.k[2]) + line("Cy", camera.k[5]) + line("f", camera.k[0]) + line("fy", camera.k[4]) +
          line("alpha", 0) + line("kappa1", k1) + line("kappa2", k2) + line("kappa3", k3) + line("tau1", p1) + line("tau2", p2);
  std::array<double, 12> projection = camera.projection;
  for (int column : {3, 7, 11}) projection[column] *= 1000;  // px*mm
  return text + rows_of("proj", projection, 4) + rows_of("rect", camera.rectification, 3);
}

std::string svs_text(const Calibration& c) {
  const Stand stand = stand_of(c);
  cv::Vec3d vector;
  cv::Rodrigues(cv::Matx33d(stand.rotation.data()), vector);
  std::string text = "# SVS Engine v 4.0 Stereo Camera Parameter File\n\n[image]\n";
  text += c.raw ? "rectified 0\n" : "rectified 1\n";
  if (c.width) {
    const std::string width = std::to_string(c.width), height = std::to_string(c.height);
    text += "width " + width + "\nheight " + height + "\nlinelen " + width + "\nlines " + height + "\n";
  }
  text += "have_rect 1\n\n[stereo]\nframe 1.0\n\n[external]\n";
  const char* axes[] = {"x ", "y ", "z "};
  for (int i : {0, 1, 2}) text += "T" + (axes[i] + number(1000 * stand.translation[i])) + "\n";
  for (int i : {0, 1, 2}) text += "R" + (axes[i] + number(vector[i])) + "\n";
  text += svs_camera(c, 0) + svs_camera(c, 1) + "\n[global]\n";
  for (const char* key : {"GTx", "GTy", "GTz", "GRx", "GRy", "GRz"}) text += std::string(key) + " 0.0\n";
  return text;
}

std::string ros_matrix(const std::string& name, int rows, int cols, std::span<const double> values) {
  return name + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(cols) + "\n  data: [" + joined(values, ", ") + "]\n";
}

std::string ros_text(const Calibration& c, int side) {
  if (!c.width) throw CalibrationError("camera_info needs the image size, and this calibration does not know it; needed is --size WxH");
  const RawCamera camera = camera_of(c, side);
  return "image_width: " + std::to_string(c.width) + "\nimage_height: " + std::to_string(c.height) +
         "\ncamera_name: " + (side == 0 ? "left" : "right") + "\n" + ros_matrix("camera_matrix", 3, 3, camera.k) +
         "distortion_model: " + (rational(camera) ? "rational_polynomial" : "plumb_bob") + "\n" +
         ros_matrix("distortion_coefficients", 1, static_cast<int>(coefficients(camera).size()), coefficients(camera)) +
         ros_matrix("rectification_matrix", 3, 3, camera.rectification) + ros_matrix("projection_matrix", 3, 4, camera.projection);
}

}  // namespace

Stand stand_of(const Calibration& calibration) {
  Stand stand;
  const cv::Vec3d beside(-calibration.view.baseline, 0, 0);
  cv::Matx33d rotation = cv::Matx33d::eye(), back = cv::Matx33d::eye();
  if (calibration.raw) {
    // Both are turned into one frame, in which the right camera is beside the left one.
    back = cv::Matx33d((*calibration.raw)[1].rectification.data()).t();
    rotation = back * cv::Matx33d((*calibration.raw)[0].rectification.data());
  }
  const cv::Vec3d translation = back * beside;
  std::copy_n(rotation.val, 9, stand.rotation.begin());
  std::copy_n(translation.val, 3, stand.translation.begin());
  return stand;
}

namespace {

/// A neighbour of `near`, or itself, for which `gives` holds: what is written reads back to the last bit, since it once came from such a
/// number.
template <class Gives>
double neighbour(double near, const Gives& gives) {
  double up = near, down = near;
  for (int step = 0; step < 4; ++step) {
    if (gives(up)) return up;
    if (gives(down)) return down;
    up = std::nextafter(up, INFINITY);
    down = std::nextafter(down, -INFINITY);
  }
  return near;
}

}  // namespace

std::array<double, 12> projection_of(const Calibration& calibration, int side) {
  if (calibration.raw) return (*calibration.raw)[side].projection;
  const StereoView& view = calibration.view;
  const double cx = side == 0 ? view.cx : neighbour(view.cx - view.cx_offset, [&](double x) { return view.cx - x == view.cx_offset; });
  const double t = side == 0 ? 0 : neighbour(-view.f * view.baseline, [&](double x) { return (0 - x) / view.f == view.baseline; });
  return {view.f, 0, cx, t, 0, view.f, view.cy, 0, 0, 0, 1, 0};
}

std::vector<CalibrationFile> calibration_texts(const Calibration& calibration, CalibrationFormat format) {
  switch (format) {
    case CalibrationFormat::svs: return {{"", svs_text(calibration)}};
    case CalibrationFormat::ros: return {{"left.yaml", ros_text(calibration, 0)}, {"right.yaml", ros_text(calibration, 1)}};
    case CalibrationFormat::opencv: break;
  }
  return {{"", opencv_text(calibration)}};
}

Calibration make_calibration(int width, int height, const std::array<RawCamera, 2>& cameras, const Stand& stand) {
  calibration::StereoParts parts;
  parts.format = "solved";
  parts.size = {width, height};
  for (int i : {0, 1}) parts.k[i] = cameras[i].k, parts.distortion[i] = cameras[i].distortion;
  parts.rotation = stand.rotation;
  parts.translation = stand.translation;
  return calibration::assemble("of these views", std::move(parts));
}

}  // namespace vdisp
