// calibration_formats.cpp: finds the files that make a calibration, reads them, and tells their format by their content.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

constexpr const char* known_formats =
    "an OpenCV YAML or XML file, an SVS .ini, KITTI's calib.txt, a EuRoC sensor.yaml or a ROS pair left.yaml and right.yaml";

bool contains(std::string_view text, std::string_view what) { return text.find(what) != std::string_view::npos; }

bool begins(std::string_view text, std::string_view what) {
  return text.size() >= what.size() && std::equal(what.begin(), what.end(), text.begin(), [](char a, char b) {
           return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
         });
}

bool line_begins(std::string_view text, std::string_view what) {
  return text.starts_with(what) || contains(text, "\n" + std::string(what));
}

bool is_euroc(std::string_view text) { return contains(text, "T_BS") && contains(text, "intrinsics"); }
bool is_ros(std::string_view text) { return contains(text, "projection_matrix") && contains(text, "rectification_matrix"); }
bool is_kitti(std::string_view text) {
  return line_begins(text, "P0:") || line_begins(text, "P2:") || line_begins(text, "P_rect_00:") || line_begins(text, "S_rect_");
}

StereoParts read_pair(const std::filesystem::path (&files)[2], StereoParts (*parse)(const std::array<NamedText, 2>&)) {
  return parse({NamedText{files[0].lexically_normal().string(), read_text(files[0])},
                NamedText{files[1].lexically_normal().string(), read_text(files[1])}});
}

StereoParts read_euroc(const std::filesystem::path& folder) {
  const std::filesystem::path files[2] = {folder / "cam0" / "sensor.yaml", folder / "cam1" / "sensor.yaml"};
  for (const auto& file : files)
    if (!std::filesystem::exists(file))
      refuse(folder.lexically_normal().string(),
             "no cam0/sensor.yaml and cam1/sensor.yaml in it; needed is the EuRoC folder mav0 or another calibration file");
  return read_pair(files, parse_euroc);
}

/// `path` is one of the pair: the other has left for right in its name.
StereoParts read_ros(const std::filesystem::path& path) {
  std::filesystem::path files[2] = {path, path};
  const std::string name = path.filename().string();
  const size_t left = name.rfind("left"), right = name.rfind("right");
  if (left == std::string::npos && right == std::string::npos)
    refuse(path.string(), "is a ROS camera_info of one camera; needed is a pair named left and right, as left.yaml and right.yaml");
  if (left != std::string::npos)
    files[1].replace_filename(std::string(name).replace(left, 4, "right"));
  else
    files[0].replace_filename(std::string(name).replace(right, 5, "left"));
  for (const auto& file : files)
    if (!std::filesystem::exists(file))
      refuse(path.string(), "is a ROS camera_info of one camera, and " + file.filename().string() + " is not beside it; needed are both");
  return read_pair(files, parse_ros);
}

StereoParts read_folder(const std::filesystem::path& folder) {
  for (const char* ending : {"yaml", "yml"})
    if (std::filesystem::exists(folder / (std::string("left.") + ending))) return read_ros(folder / (std::string("left.") + ending));
  if (std::filesystem::exists(folder / "calib.txt")) return read_parts(folder / "calib.txt", {});
  return read_euroc(std::filesystem::exists(folder / "mav0") ? folder / "mav0" : folder);
}

}  // namespace

StereoParts parse_single(const std::string& file, const std::string& text, const ReadingOptions& options) {
  if (begins(text, "# SVS Engine") || contains(text, "[left camera]")) return parse_svs(file, text, options);
  if (begins(text, "%YAML") || begins(text, "<?xml") || contains(text, "opencv-matrix")) return parse_opencv(file, text);
  if (is_kitti(text)) return parse_kitti(file, text, options);
  refuse(file, std::string("of no known format; needed is ") + known_formats);
}

StereoParts read_parts(const std::filesystem::path& path, const ReadingOptions& options) {
  if (std::filesystem::is_directory(path)) return read_folder(path);
  const std::string content = read_text(path);
  if (is_euroc(content)) {
    const std::string camera = std::filesystem::absolute(path).parent_path().filename().string();
    if (camera != "cam0" && camera != "cam1")
      refuse(path.string(), "is one camera of EuRoC's in a folder " + camera + "; needed are cam0/sensor.yaml and cam1/sensor.yaml");
    return read_euroc(path.parent_path() / "..");
  }
  if (is_ros(content) && !contains(content, "opencv-matrix")) return read_ros(path);
  return parse_single(path.string(), content, options);
}

std::string read_text(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) refuse(path.string(), "cannot be read: " + std::generic_category().message(errno));
  std::string content(1 << 20, '\0');
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  if (in.bad()) refuse(path.string(), "cannot be read: " + std::generic_category().message(errno));
  if (in.gcount() == static_cast<std::streamsize>(content.size())) refuse(path.string(), "is larger than 1 MiB: no calibration file");
  content.resize(static_cast<size_t>(in.gcount()));
  if (content.empty()) refuse(path.string(), "is empty; needed is a calibration");
  if (content.find('\0') != std::string::npos) refuse(path.string(), std::string("holds binary data; needed is ") + known_formats);
  return content;
}

}  // namespace vdisp::calibration
