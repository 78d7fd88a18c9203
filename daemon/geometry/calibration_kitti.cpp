// calibration_kitti.cpp: KITTI's calibrations: calib.txt (P0 .. P3) and calib_cam_to_cam.txt (all of cameras 0 to 3).
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

/// Lines "name: number number ...".
class Lines {
 public:
  Lines(std::string file, const std::string& content) : file_(std::move(file)) {
    std::istringstream in(content);
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      const size_t colon = line.find(':');
      if (colon != std::string::npos) entries_[line.substr(0, colon)] = {line.substr(colon + 1), number};
    }
    // Half a number is a number too.
    if (content.back() != '\n' && !entries_.empty()) cut_off_ = static_cast<int>(std::count(content.begin(), content.end(), '\n')) + 1;
  }

  bool has(const std::string& name) const { return entries_.contains(name); }

  template <size_t n>
  std::array<double, n> numbers(const std::string& name) const {
    const auto found = entries_.find(name);
    if (found == entries_.end()) refuse(file_, "has no " + name + "; needed is it of both cameras");
    const std::string where = file_ + ":" + std::to_string(found->second.line);
    if (found->second.line == cut_off_) refuse(where, "the file ends within " + name + ": it is truncated");
    std::array<double, n> result{};
    std::istringstream words(found->second.text);
    std::string word;
    size_t count = 0;
    for (; words >> word; ++count)
      if (count < n) result[count] = parse(where, name, word);
    if (count != n) refuse(where, name + " has " + std::to_string(count) + " numbers, needed are " + std::to_string(n));
    return result;
  }

 private:
  struct Entry {
    std::string text;
    int line;
  };

  static double parse(const std::string& where, const std::string& name, std::string_view word) {
    double value = NAN;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      refuse(where, name + " holds '" + std::string(word.substr(0, 20)) + "', needed are numbers");
    return value;
  }

  std::string file_;
  std::map<std::string, Entry> entries_;
  int cut_off_ = 0;  // the last line, where it does not end
};

}  // namespace

StereoParts parse_kitti(const std::string& file, const std::string& content, const ReadingOptions& options) {
  const Lines lines(file, content);
  StereoParts parts;
  parts.format = "KITTI";
  const bool every_camera = lines.has("P_rect_00") || lines.has("P_rect_02");
  // Files of the colour cameras alone are about in the wild.
  const bool colour = options.colour || !lines.has(every_camera ? "P_rect_00" : "P0");
  parts.images_are_rectified = !every_camera || !options.unrectified;
  if (!every_camera && options.unrectified) refuse(file, "knows rectified images only; needed for others is calib_cam_to_cam.txt");
  for (int i : {0, 1}) {
    const std::string number = std::to_string((colour ? 2 : 0) + i);
    if (!every_camera) {
      parts.projection[i] = lines.numbers<12>("P" + number);
      continue;
    }
    parts.projection[i] = lines.numbers<12>("P_rect_0" + number);
    const auto sides = lines.numbers<2>((options.unrectified ? "S_0" : "S_rect_0") + number);
    const auto wanted = whole_size(file, sides[0], sides[1]);
    if (parts.size && *parts.size != wanted) refuse(file, "the two cameras' image sizes differ; needed is one");
    parts.size = wanted;
    if (!options.unrectified) continue;
    parts.k[i] = lines.numbers<9>("K_0" + number);
    const auto d = lines.numbers<5>("D_0" + number);
    std::copy(d.begin(), d.end(), parts.distortion[i].emplace().begin());
    parts.rectification[i] = lines.numbers<9>("R_rect_0" + number);
  }
  // KITTI's projections hold the place of each camera beside camera 0, up to some mm above and ahead of it, which rectified views cannot
  // have.
  for (int i : {0, 1}) (*parts.projection[i])[7] = (*parts.projection[i])[11] = 0;
  return parts;
}

}  // namespace vdisp::calibration
