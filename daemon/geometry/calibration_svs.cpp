// calibration_svs.cpp: SVS and smallvcal calibration files (.ini, from version 2.1 on), in mm there, in m here.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

constexpr std::string_view sections[] = {"image", "stereo", "external", "left camera", "right camera", "global"};

std::string lower(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// The keys of the file as "section/key", with the numbers that follow and the line they stand in.
class Ini {
 public:
  Ini(std::string file, const std::string& content) : file_(std::move(file)), in_(content) {
    read_header();
    std::string line, section;
    while (next(line)) {
      if (line.empty() || line[0] == ' ' || line[0] == '#' || line[0] == '\t') continue;
      if (line[0] == '[')
        section = section_of(line);
      else
        read_key(section, line);
    }
    check_end(content);
  }

  const std::string& version() const { return version_; }
  bool has(const std::string& key) const { return entries_.contains(key); }

  double number(const std::string& key, double otherwise) const {
    const auto found = entries_.find(key);
    return found == entries_.end() ? otherwise : found->second.values[0];
  }
  double number(const std::string& key) const {
    if (!has(key))
      refuse(file_, "no '" + key.substr(key.find('/') + 1) + "' in [" + key.substr(0, key.find('/')) + "]; needed for the cameras");
    return number(key, 0);
  }
  template <size_t n>
  std::optional<std::array<double, n>> matrix(const std::string& key) const {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return {};
    std::array<double, n> result{};
    std::copy_n(found->second.values.begin(), n, result.begin());
    return result;
  }
  [[noreturn]] void refuse_key(const std::string& key, const std::string& what) const {
    refuse(file_ + ":" + std::to_string(entries_.at(key).line), key.substr(key.find('/') + 1) + ' ' + what);
  }

 private:
  struct Entry {
    std::vector<double> values;
    int line;
  };

  bool next(std::string& line) {
    if (!std::getline(in_, line)) return false;
    while (!line.empty() && line.back() == '\r') line.pop_back();
    ++line_;
    return true;
  }

  [[noreturn]] void refuse_line(const std::string& what) const { refuse(file_ + ":" + std::to_string(line_), what); }

  void read_header() {
    constexpr std::string_view head = "# svs engine v ";
    std::string line;
    next(line);
    int major = 0, minor = 0;
    const bool headed = lower(line).starts_with(head);
    if (!headed || std::sscanf(line.c_str() + head.size(), "%d.%d", &major, &minor) != 2)
      refuse_line("begins with '" + line.substr(0, 40) + "', needed is '# SVS Engine v 2.1' or later");
    version_ = std::to_string(major) + "." + std::to_string(minor);
    if (major * 10 + minor < 21) refuse_line("version " + version_ + " is too old, needed is 2.1 or later");
  }

  std::string section_of(const std::string& line) const {
    const std::string name = lower(std::string_view(line).substr(1));
    for (std::string_view known : sections)
      if (name.starts_with(known)) return std::string(known);
    return "unknown";
  }

  /// A key is the whole first word: "f" is not "fy".
  void read_key(const std::string& section, const std::string& line) {
    std::istringstream words(line);
    std::string key, value;
    words >> key >> value;
    key = lower(key);
    const bool camera = section.ends_with("camera");
    if (camera && (key == "proj" || key == "rect")) {
      const int begin = line_, columns = key == "proj" ? 4 : 3;
      std::vector<double> values;
      for (int row = 0; row < 3; ++row) read_row(key, columns, values);
      entries_[section + "/" + key] = {values, begin};
      return;
    }
    const bool needed = camera || section == "external" ||
                        (section == "image" && (key == "width" || key == "height" || key == "rectified" || key == "have_rect"));
    if (!needed) return;
    entries_[section + "/" + key] = {{parse(key, value)}, line_};
    last_needed_ = line_;
  }

  void read_row(const std::string& key, int columns, std::vector<double>& values) {
    std::string line, word;
    if (!next(line)) {
      ++line_;
      refuse_line("the file ends within '" + key + "', needed are 3 rows of " + std::to_string(columns) + " numbers");
    }
    last_needed_ = line_;
    std::istringstream words(line);
    for (int i = 0; i < columns; ++i) {
      if (!(words >> word))
        refuse_line("a row of '" + key + "' has " + std::to_string(i) + " numbers, needed are " + std::to_string(columns));
      values.push_back(parse(key, word));
    }
    if (words >> word)
      refuse_line("a row of '" + key + "' goes on with '" + word.substr(0, 20) + "', needed are " + std::to_string(columns) + " numbers");
  }

  double parse(const std::string& key, std::string_view word) const {
    double value = NAN;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      refuse_line("'" + key + "' is '" + std::string(word.substr(0, 20)) + "', needed is a number");
    return value;
  }

  /// Half a number is a number too: a file cut off within its last line of cameras is not to be believed.
  void check_end(const std::string& content) const {
    if (content.back() != '\n' && last_needed_ == line_) refuse_line("the file ends within a line: it is truncated");
  }

  std::string file_, version_;
  std::istringstream in_;
  int line_ = 0, last_needed_ = 0;
  std::map<std::string, Entry> entries_;
};

void read_camera(const Ini& ini, const std::string& section, int i, StereoParts& parts) {
  const auto key = [&section](const char* name) { return section + "/" + name; };
  const double f = ini.number(key("f")), fy = ini.number(key("fy"), -1);
  if (f <= 0) ini.refuse_key(key("f"), "is " + text(f) + " px, needed is more than 0");
  parts.k[i] = {f, 0, ini.number(key("cx")), 0, fy > 0 ? fy : f, ini.number(key("cy")), 0, 0, 1};
  parts.distortion[i] = {ini.number(key("kappa1"), 0),
                         ini.number(key("kappa2"), 0),
                         ini.number(key("tau1"), 0),
                         ini.number(key("tau2"), 0),
                         ini.number(key("kappa3"), 0),
                         0,
                         0,
                         0};
  parts.rectification[i] = ini.matrix<9>(key("rect"));
  parts.projection[i] = ini.matrix<12>(key("proj"));
  if (parts.projection[i])
    for (int column : {3, 7, 11}) (*parts.projection[i])[column] /= 1000;  // px*mm
}

std::optional<std::array<int, 2>> image_size(const std::string& file, const Ini& ini) {
  const auto pair = [&](const std::string& section, const char* w, const char* h) {
    return whole_size(file, ini.number(section + "/" + w, 0), ini.number(section + "/" + h, 0));
  };
  const auto left = pair("left camera", "pwidth", "pheight"), right = pair("right camera", "pwidth", "pheight");
  if (left != right)
    refuse(file, "the left camera is " + std::to_string(left[0]) + "x" + std::to_string(left[1]) + ", the right one " +
                     std::to_string(right[0]) + "x" + std::to_string(right[1]) + "; needed is one size");
  if (ini.has("left camera/pwidth") || ini.has("left camera/pheight")) return left;
  if (ini.has("image/width") || ini.has("image/height")) return pair("image", "width", "height");
  return {};
}

}  // namespace

StereoParts parse_svs(const std::string& file, const std::string& content, const ReadingOptions& options) {
  const Ini ini(file, content);
  StereoParts parts;
  parts.format = "SVS " + ini.version();
  parts.size = image_size(file, ini);
  read_camera(ini, "left camera", 0, parts);
  read_camera(ini, "right camera", 1, parts);
  // Rx, Ry, Rz are a rotation vector, whatever comments in such files say.
  const cv::Vec3d vector(ini.number("external/rx", 0), ini.number("external/ry", 0), ini.number("external/rz", 0));
  cv::Matx33d rotation;
  cv::Rodrigues(vector, rotation);
  std::copy_n(rotation.val, 9, parts.rotation.emplace().begin());
  parts.translation = {ini.number("external/tx") / 1000, ini.number("external/ty", 0) / 1000, ini.number("external/tz", 0) / 1000};

  // Of the images the file belongs to. Someone who has raw images of that camera sets it to 0.
  parts.images_are_rectified = ini.number("image/rectified", 0) != 0 && !options.unrectified;
  const bool all = parts.rectification[0] && parts.rectification[1] && parts.projection[0] && parts.projection[1];
  if (ini.number("image/have_rect", all ? 1 : 0) == 0) {
    for (int i : {0, 1}) parts.rectification[i].reset(), parts.projection[i].reset();
    if (parts.images_are_rectified) refuse(file, "rectified is 1 but have_rect is 0; needed are proj and rect of rectified images");
  } else if (!all) {
    refuse(file, "have_rect is 1 but proj or rect of a camera is missing; needed are both of both");
  }
  return parts;
}

}  // namespace vdisp::calibration
