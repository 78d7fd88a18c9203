// calibration_yaml.cpp: calibrations in OpenCV's FileStorage (YAML, XML) and in EuRoC's sensor.yaml.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

/// A FileStorage text with the names of its file for messages.
class Sheet {
 public:
  Sheet(std::string file, const std::string& content) : file_(std::move(file)) {
    // EuRoC's own files lack the first line that OpenCV insists on.
    const bool headed = content.starts_with("%YAML") || content.starts_with("<?xml");
    try {
      storage_.open(headed ? content : "%YAML:1.0\n---\n" + content, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    } catch (const cv::Exception& e) {
      std::string why = e.err;
      std::replace(why.begin(), why.end(), '\n', ' ');
      refuse(file_, "is damaged: " + why);
    }
    if (!storage_.isOpened()) refuse(file_, "is damaged: no FileStorage document");
  }

  const std::string& file() const { return file_; }

  /// The first of the names that the file has.
  cv::FileNode find(std::initializer_list<const char*> names, std::string* found = nullptr) const {
    for (const char* name : names) {
      cv::FileNode node = storage_[name];
      if (node.empty()) continue;
      if (found) *found = name;
      return node;
    }
    return {};
  }

  /// Numbers of a matrix (rows, cols, data) or of a plain list; empty where the file has none of the names.
  std::vector<double> numbers(std::initializer_list<const char*> names, int* rows = nullptr, int* cols = nullptr) const {
    std::string name;
    const cv::FileNode node = find(names, &name);
    if (node.empty()) return {};
    const cv::FileNode data = node.isMap() ? node["data"] : node;
    if (!data.isSeq() || data.size() == 0) refuse(file_, name + " is no matrix; needed is rows, cols and data, or a list of numbers");
    std::vector<double> values;
    for (const cv::FileNode& item : data) {
      if (!item.isReal() && !item.isInt()) refuse(file_, name + " holds something that is no number");
      values.push_back(static_cast<double>(item));
      if (!std::isfinite(values.back())) refuse(file_, name + " holds " + text(values.back()) + ", needed are finite numbers");
    }
    int r = 0, c = static_cast<int>(values.size());
    if (node.isMap()) {
      r = whole(node["rows"], name + " rows");
      c = whole(node["cols"], name + " cols");
      if (static_cast<size_t>(r) * c != values.size())
        refuse(file_,
               name + " has " + std::to_string(values.size()) + " numbers, needed are " + std::to_string(r) + "x" + std::to_string(c));
    }
    if (rows) *rows = r;
    if (cols) *cols = c;
    return values;
  }

  /// A matrix of this size; a plain list of as many numbers is one too.
  template <size_t n>
  std::optional<std::array<double, n>> matrix(std::initializer_list<const char*> names, int rows, int cols) const {
    int r = 0, c = 0;
    const std::vector<double> values = numbers(names, &r, &c);
    if (values.empty()) return {};
    const bool vector = cols == 1 && values.size() == n;  // a translation may lie or stand
    if (values.size() != n || (r != 0 && !vector && (r != rows || c != cols))) {
      std::string name;
      find(names, &name);
      refuse(file_, name + " is " + (r == 0 ? std::to_string(c) + " numbers" : std::to_string(r) + "x" + std::to_string(c)) +
                        ", needed is " + std::to_string(rows) + "x" + std::to_string(cols));
    }
    std::array<double, n> result{};
    std::copy(values.begin(), values.end(), result.begin());
    return result;
  }

  std::optional<std::array<double, 8>> distortion(std::initializer_list<const char*> names) const {
    std::string name;
    const std::vector<double> values = numbers(names);
    if (values.empty()) return {};
    find(names, &name);
    const bool padded = values.size() > 8 && std::all_of(values.begin() + 8, values.end(), [](double value) { return value == 0; });
    if (values.size() != 4 && values.size() != 5 && values.size() != 8 && !padded)
      refuse(file_, name + " has " + std::to_string(values.size()) + " coefficients, needed are 4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6)");
    std::array<double, 8> result{};
    std::copy_n(values.begin(), std::min<size_t>(values.size(), 8), result.begin());
    return result;
  }

  int whole(const cv::FileNode& node, const std::string& name) const {
    const double value = node.isInt() || node.isReal() ? static_cast<double>(node) : NAN;
    if (!(value >= 0 && value < 1e6 && value == std::floor(value))) refuse(file_, name + " is no whole number");
    return static_cast<int>(value);
  }

 private:
  std::string file_;
  cv::FileStorage storage_;
};

std::optional<std::array<int, 2>> image_size(const Sheet& sheet) {
  const cv::FileNode width = sheet.find({"image_width", "imageWidth", "image_Width"}),
                     height = sheet.find({"image_height", "imageHeight", "image_Height"});
  if (!width.empty() && !height.empty()) return std::array{sheet.whole(width, "image_width"), sheet.whole(height, "image_height")};
  if (width.empty() != height.empty()) refuse(sheet.file(), "has one of image_width and image_height; needed are both");
  const auto size = sheet.matrix<2>({"image_size", "imageSize", "size"}, 2, 1);
  if (!size) return {};
  return std::array{static_cast<int>((*size)[0]), static_cast<int>((*size)[1])};
}

struct EurocCamera {
  cv::Matx44d body_from_camera;
  std::array<double, 9> k;
  std::array<double, 8> distortion;
  std::array<int, 2> size;
};

EurocCamera read_euroc_camera(const std::filesystem::path& path) {
  const Sheet sheet(path.string(), read_text(path));
  const auto word = [&sheet](const char* name) {
    const cv::FileNode node = sheet.find({name});
    return node.isString() ? static_cast<std::string>(node) : std::string();
  };
  const std::string model = word("camera_model"), lens = word("distortion_model");
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
  return {cv::Matx44d(pose->data()),
          {fx, 0, cx, 0, fy, cy, 0, 0, 1},
          *distortion,
          {static_cast<int>((*size)[0]), static_cast<int>((*size)[1])}};
}

}  // namespace

StereoParts parse_opencv(const std::string& file, const std::string& content) {
  const Sheet sheet(file, content);
  StereoParts parts;
  parts.format = "OpenCV";
  parts.size = image_size(sheet);
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

StereoParts read_euroc(const std::filesystem::path& folder) {
  const std::filesystem::path files[] = {folder / "cam0" / "sensor.yaml", folder / "cam1" / "sensor.yaml"};
  for (const auto& file : files)
    if (!std::filesystem::exists(file))
      refuse(folder.lexically_normal().string(),
             "no cam0/sensor.yaml and cam1/sensor.yaml in it; needed is the EuRoC folder mav0 or another calibration file");
  const EurocCamera left = read_euroc_camera(files[0]), right = read_euroc_camera(files[1]);
  if (left.size != right.size) refuse(files[1].lexically_normal().string(), "its resolution differs from cam0's; needed is one");
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
