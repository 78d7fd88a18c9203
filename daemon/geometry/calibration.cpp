// calibration.cpp: checks what a calibration file says and makes the rectified view of it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/geometry/calibration.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp {
namespace calibration {
namespace {

constexpr int smallest = 16, largest = 16384;  // px, of an image
constexpr double longest_baseline = 10;        // m: more is a file in millimetres
constexpr const char* side[] = {"left", "right"};

void check_size(const std::string& file, const StereoParts& parts) {
  if (!parts.size) return;
  for (int side_length : *parts.size)
    if (side_length < smallest || side_length > largest)
      refuse(file, "image size is " + std::to_string((*parts.size)[0]) + "x" + std::to_string((*parts.size)[1]) + ", needed is " +
                       std::to_string(smallest) + " to " + std::to_string(largest) + " px each way");
}

void check_rotation(const std::string& file, const std::string& which, const std::array<double, 9>& values) {
  const cv::Matx33d r(values.data());
  const double error = cv::norm(r * r.t() - cv::Matx33d::eye(), cv::NORM_INF);
  if (error > 1e-3 || cv::determinant(r) < 0)
    refuse(file, which + " is no rotation (R R' differs from 1 by " + text(error) + ", determinant " + text(cv::determinant(r)) + ")");
}

void check_camera(const std::string& file, const std::string& which, const StereoParts& parts, const std::array<double, 9>& k) {
  const double fx = k[0], fy = k[4], cx = k[2], cy = k[5];
  if (fx <= 0 || fy <= 0) refuse(file, which + " camera: f is " + text(fx) + ", " + text(fy) + " px, needed is more than 0");
  if (fx > 2 * fy || fy > 2 * fx)
    refuse(file, which + " camera: fx " + text(fx) + " and fy " + text(fy) + " px differ by more than a factor 2");
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) refuse(file, which + " camera: matrix is not (fx 0 cx; 0 fy cy; 0 0 1)");
  if (parts.size && (cx < 0 || cy < 0 || cx > (*parts.size)[0] || cy > (*parts.size)[1]))
    refuse(file, which + " camera: optical centre " + text(cx) + ", " + text(cy) + " lies outside the image of " +
                     std::to_string((*parts.size)[0]) + "x" + std::to_string((*parts.size)[1]));
}

void check_baseline(const std::string& file, double baseline) {
  if (std::abs(baseline) < 1e-4) refuse(file, "no baseline (" + text(baseline) + " m); needed is the distance of the cameras");
  if (baseline < 0)
    refuse(file, "the right camera lies left of the left one (baseline " + text(baseline) + " m); needed is left and right exchanged");
  if (baseline > longest_baseline)
    refuse(file,
           "baseline is " + text(baseline) + " m, at most " + text(longest_baseline) + " is likely; needed are metres, not millimetres");
}

void check_projection(const std::string& file, const std::string& which, const std::array<double, 12>& p) {
  const double fx = p[0], fy = p[5];
  if (fx <= 0 || fy <= 0) refuse(file, which + " projection: f is " + text(fx) + ", " + text(fy) + " px, needed is more than 0");
  if (std::abs(fx - fy) > 0.005 * fx)
    refuse(file, which + " projection: fx " + text(fx) + ", fy " + text(fy) + "; a rectified view has one f");
  if (std::abs(p[1]) > 1e-6 * fx || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1)
    refuse(file, which + " projection is not (f 0 cx t; 0 f cy 0; 0 0 1 0)");
}

StereoView rectified_view(const std::string& file, const StereoParts& parts) {
  const auto &left = *parts.projection[0], &right = *parts.projection[1];
  for (int i : {0, 1}) check_projection(file, side[i], *parts.projection[i]);
  if (std::abs(left[0] - right[0]) > 1e-3 * left[0])
    refuse(file, "f is " + text(left[0]) + " px left and " + text(right[0]) + " right; a rectified pair has one f");
  if (std::abs(left[6] - right[6]) > 0.5)
    refuse(file, "cy is " + text(left[6]) + " left and " + text(right[6]) + " right; in a rectified pair the rows agree");
  if (std::abs(right[7] - left[7]) > std::abs(right[3] - left[3]))
    refuse(file, "the cameras are one above the other; needed is one beside the other");
  const StereoView view{left[0], left[2], left[6], (left[3] - right[3]) / left[0], left[2] - right[2]};
  check_baseline(file, view.baseline);
  if (parts.size) {
    const double w = (*parts.size)[0], h = (*parts.size)[1];
    if (view.cx < -w || view.cx > 2 * w || view.cy < -h || view.cy > 2 * h)
      refuse(file, "optical centre " + text(view.cx) + ", " + text(view.cy) + " is far outside the image of " + text(w) + "x" + text(h));
  }
  return view;
}

/// A rectified view is about as large as the raw one.
void check_views(const std::string& file, const StereoParts& parts) {
  for (int i : {0, 1}) {
    const double f = (*parts.k[i])[0], rectified = (*parts.projection[i])[0];
    if (rectified > 0 && (f < rectified / 4 || f > rectified * 4))
      refuse(file,
             std::string(side[i]) + " camera: f is " + text(f) + " raw and " + text(rectified) + " rectified; needed are pixels in both");
  }
}

/// Where the file has cameras and their places only: rectification with equal cx, and no black borders (alpha 0).
void rectify(const std::string& file, StereoParts& parts) {
  if (!parts.rotation || !parts.translation)
    refuse(file, "has camera matrices but neither R and T nor R1, R2, P1, P2; needed is where the cameras stand");
  if (!parts.size) refuse(file, "has no image size, needed to rectify: image_width and image_height");
  check_rotation(file, "R", *parts.rotation);
  const cv::Matx33d r(parts.rotation->data());
  const cv::Vec3d t(parts.translation->data());
  const cv::Vec3d right_in_left = -(r.t() * t);
  if (std::abs(right_in_left[1]) > std::abs(right_in_left[0]))
    refuse(file, "the cameras are one above the other; needed is one beside the other");
  check_baseline(file, std::copysign(cv::norm(t), right_in_left[0]));
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(cv::Mat(3, 3, CV_64F, parts.k[0]->data()), cv::Mat(1, 8, CV_64F, parts.distortion[0]->data()),
                    cv::Mat(3, 3, CV_64F, parts.k[1]->data()), cv::Mat(1, 8, CV_64F, parts.distortion[1]->data()),
                    cv::Size((*parts.size)[0], (*parts.size)[1]), r, t, r1, r2, p1, p2, q, cv::CALIB_ZERO_DISPARITY, 0);
  for (int i : {0, 1}) {
    const cv::Mat &rotation = i == 0 ? r1 : r2, &projection = i == 0 ? p1 : p2;
    if (!cv::checkRange(rotation) || !cv::checkRange(projection))
      refuse(file, "cannot be rectified: distortion and matrices contradict each other");
    std::copy_n(rotation.ptr<double>(), 9, parts.rectification[i].emplace().begin());
    std::copy_n(projection.ptr<double>(), 12, parts.projection[i].emplace().begin());
  }
  check_views(file, parts);
}

/// Both ways in which a file tells the baseline must agree. SVS's proj leaves out Ty and Tz, hence 2 %.
void check_agreement(const std::string& file, const StereoParts& parts, const StereoView& view) {
  if (!parts.translation) return;
  const double distance = cv::norm(cv::Vec3d(parts.translation->data()));
  if (std::abs(distance - view.baseline) > 0.02 * view.baseline)
    refuse(file,
           "baseline is " + text(view.baseline) + " m by the projection and " + text(distance) + " m by the translation; needed is one");
}

uint64_t hash(const Calibration& c) {
  uint64_t h = 0xcbf29ce484222325;  // FNV-1a
  const auto add = [&h](double value) {
    const auto bits = std::bit_cast<uint64_t>(value + 0.0);  // -0 is 0
    for (int shift = 0; shift < 64; shift += 8) h = (h ^ (bits >> shift & 255)) * 0x100000001b3;
  };
  for (double value :
       {static_cast<double>(c.width), static_cast<double>(c.height), c.view.f, c.view.cx, c.view.cy, c.view.baseline, c.view.cx_offset})
    add(value);
  if (!c.raw) return h;
  for (const RawCamera& camera : *c.raw) {
    std::for_each(camera.k.begin(), camera.k.end(), add);
    std::for_each(camera.distortion.begin(), camera.distortion.end(), add);
    std::for_each(camera.rectification.begin(), camera.rectification.end(), add);
    std::for_each(camera.projection.begin(), camera.projection.end(), add);
  }
  return h;
}

void check_raw(const std::string& file, StereoParts& parts) {
  for (int i : {0, 1}) {
    if (!parts.k[i])
      refuse(file, std::string("has a matrix of the ") + side[1 - i] + " camera but none of the " + side[i] + " one; needed are both");
    if (!parts.distortion[i]) refuse(file, std::string("has no distortion of the ") + side[i] + " camera; needed beside its matrix");
    check_camera(file, side[i], parts, *parts.k[i]);
  }
  const bool complete = parts.rectification[0] && parts.rectification[1] && parts.projection[0] && parts.projection[1];
  if (!complete) return rectify(file, parts);
  for (int i : {0, 1}) check_rotation(file, std::string("rectification of the ") + side[i] + " camera", *parts.rectification[i]);
  check_views(file, parts);
}

}  // namespace

Calibration assemble(const std::string& file, StereoParts parts) {
  check_size(file, parts);
  const bool raw = (parts.k[0] || parts.k[1]) && !parts.images_are_rectified;
  if (raw)
    check_raw(file, parts);
  else if (!parts.projection[0] || !parts.projection[1])
    refuse(file, "has neither projections P1 and P2 nor camera matrices with distortion, R and T; needed is one of the two");
  else if (!parts.images_are_rectified && (parts.rectification[0] || parts.rectification[1]))
    refuse(file, "has R1 or R2 but no camera matrices and distortion; needed is all of it in one file");
  Calibration result;
  if (parts.size) result.width = (*parts.size)[0], result.height = (*parts.size)[1];
  result.view = rectified_view(file, parts);
  check_agreement(file, parts, result.view);
  if (raw) {
    auto& cameras = result.raw.emplace();
    for (int i : {0, 1}) cameras[i] = {*parts.k[i], *parts.distortion[i], *parts.rectification[i], *parts.projection[i]};
  }
  result.format = parts.format;
  result.hash = hash(result);
  return result;
}

Calibration assemble_from(const std::string& file, const std::function<StereoParts()>& parse) {
  try {
    return assemble(file, parse());
  } catch (const cv::Exception& e) {
    std::string why = e.err;
    std::replace(why.begin(), why.end(), '\n', ' ');
    refuse(file, "OpenCV refuses it: " + why);
  } catch (const std::filesystem::filesystem_error& e) {
    refuse(file, "cannot be read: " + e.code().message());
  }
}

void refuse(const std::string& file, const std::string& what) { throw CalibrationError("calibration " + file + ": " + what); }

std::array<int, 2> whole_size(const std::string& file, double width, double height) {
  for (const double side_length : {width, height})
    if (!(side_length >= 0 && side_length < 1e6))
      refuse(file, "image size is " + text(width) + "x" + text(height) + ", needed is " + std::to_string(smallest) + " to " +
                       std::to_string(largest) + " px each way");
  return {static_cast<int>(width), static_cast<int>(height)};
}

std::string text(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", number);
  return buffer;
}

}  // namespace calibration

Calibration read_calibration(const std::filesystem::path& path, const ReadingOptions& options) {
  return calibration::assemble_from(path.string(), [&] { return calibration::read_parts(path, options); });
}

Calibration parse_calibration(const std::string& name, const std::string& text) {
  return calibration::assemble_from(name, [&] { return calibration::parse_single(name, text, {}); });
}

}  // namespace vdisp
