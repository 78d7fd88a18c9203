// check.cpp: what no range can say: values that contradict each other.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "config/cpu_list.h"
#include "config/parameters.h"
#include "config/quoting.h"

namespace vdisp {
namespace {

constexpr double most_cells = 4096;
constexpr size_t longest_name = 100;  // what an iceoryx instance may have

class Check {
 public:
  explicit Check(const Config& config) : config_(config) {}
  std::vector<Contradiction> found;

  /// "anglefloorMin = 0.9"
  std::string value(const char* name) const {
    const Parameter* row = find_parameter(name);
    return std::string(row->key) + " = " + printable(row->get(config_));
  }
  void refuse(std::vector<std::string> parameters, std::string text) { found.push_back({std::move(parameters), std::move(text)}); }

  void floor() {
    if (config_.floor.anglefloorMin < config_.floor.anglefloorMax) return;
    refuse({"Floor.anglefloorMin", "Floor.anglefloorMax"},
           value("Floor.anglefloorMin") + ", must be less than " + value("Floor.anglefloorMax"));
  }

  void decide() {
    if (config_.decide.leastSpeed > config_.decide.speed)
      refuse({"decide.leastSpeed", "decide.speed"}, value("decide.leastSpeed") + ", must be at most " + value("decide.speed"));
    if (config_.decide.near >= config_.decide.far)
      refuse({"decide.near", "decide.far"}, value("decide.near") + ", must be less than " + value("decide.far"));
  }

  void snow() {
    if (!config_.detects("snow") || !config_.snow.model.empty()) return;
    refuse({"main.detectors", "snow.model"},
           value("main.detectors") + " without [snow] model, must have what vdisp-train makes of recordings: model = a file");
  }

  void cells(const char* side, double metres) {
    const double count = std::round(metres / config_.map.cell);
    if (count >= 1 && count <= most_cells) return;
    refuse({side, "Map.cell"}, value(side) + " m with " + value("Map.cell") + " m makes " + std::to_string(std::lround(count)) +
                                   " cells, must be from 1 to 4096");
  }

  void angle() {
    const double a = config_.limit.angRot, b = config_.map.angRot;
    if (a == b || (std::isnan(a) && std::isnan(b))) return;
    refuse({"Limit obstacle.angRot", "Map.angRot"},
           value("Map.angRot") + " in [Map], must be the same as in [Limit obstacle], where " + value("Limit obstacle.angRot"));
  }

  void files() {
    const auto& s = config_.image_source;
    if (!s.recording.empty() && s.source == "files") {
      if (!s.left.empty())
        refuse({"image source.recording", "image source.left"},
               value("image source.recording") + " and " + value("image source.left") + ", must be one of them");
      if (!s.odometry.empty())
        refuse({"image source.recording", "image source.odometry"},
               value("image source.odometry") + " with a recording, must be left out: recording tells its own");
    } else if (s.left.empty() && !s.right.empty()) {
      refuse({"image source.right", "image source.left"}, value("image source.right") + " without left, must have the left images too");
    } else if (s.left.empty() && s.source == "files") {
      refuse({"image source.source", "image source.left"},
             "source = files without left, must have left = a pattern, a glob or a video, or recording = a folder");
    } else if (!s.left.empty() && s.left == s.right) {
      refuse({"image source.left", "image source.right"},
             value("image source.right") + " is the same as left, must be the other camera's images; leave it out for one video with both");
    }
  }

  void recorder() {
    if (config_.recorder.seconds <= 0 || !config_.recorder.folder.empty()) return;
    refuse({"recorder.seconds", "recorder.folder"}, value("recorder.seconds") + " without folder, must have folder = where to write");
  }

  void mosaic() {
    const auto& s = config_.image_source;
    if (s.source != "sim" || s.bayer == "none") return;
    refuse({"image source.bayer", "image source.source"},
           value("image source.bayer") + " with source = sim, must be none: its images are grey");
  }

  void sizes() {
    const auto& s = config_.image_source;
    size(s.source, "image source.width", s.width, "sim.width", config_.sim.width);
    size(s.source, "image source.height", s.height, "sim.height", config_.sim.height);
    const bool sim = s.source == "sim";
    const int width = s.width > 0 ? s.width : sim ? config_.sim.width : 0;
    const int height = s.height > 0 ? s.height : sim ? config_.sim.height : 0;
    const char* named_width = s.width > 0 ? "image source.width" : "sim.width";
    const char* named_height = s.height > 0 ? "image source.height" : "sim.height";
    const int columns = s.ndisp + std::max(0, s.minDisparity) + s.corrsize;
    if (width > 0 && columns > width) {
      refuse({"image source.ndisp", "image source.minDisparity", "image source.corrsize", named_width},
             value("image source.ndisp") + " with " + value("image source.minDisparity") + " and " + value("image source.corrsize") +
                 " needs " + std::to_string(columns) + " columns, must fit " + value(named_width));
    }
    if (height > 0 && s.corrsize > height) {
      refuse({"image source.corrsize", named_height}, value("image source.corrsize") + ", must fit " + value(named_height));
    }
  }

  void search() {
    const auto& s = config_.image_source;
    if (s.minDisparity + s.ndisp > 0) return;
    refuse(
        {"image source.ndisp", "image source.minDisparity"},
        value("image source.ndisp") + " with " + value("image source.minDisparity") + " searches beyond infinity alone, must end above 0");
  }

  void name() {
    const std::string& name = config_.main.name;
    // iceoryx separates the parts of its messages by commas.
    if (std::any_of(name.begin(), name.end(), [](char c) { return c == ',' || is_blank(c) || is_control(c); }))
      refuse({"main.name"}, value("main.name") + ", must be without commas, blanks and control characters");
    if (!name.empty() && name.size() <= longest_name) return;
    refuse({"main.name"}, "name has " + std::to_string(name.size()) + " bytes, must have from 1 to " + std::to_string(longest_name));
  }

  void cpus() {
    if (config_.main.cpus.empty() || cpu_list(config_.main.cpus)) return;
    refuse({"main.cpus"}, value("main.cpus") + ", must be numbers of processors from 0 to " + std::to_string(largest_cpu) +
                              " and ranges of them, as 0,2-3");
  }

 private:
  void size(const std::string& source, const char* asked, int pixels, const char* made, int simulated) {
    if (source != "sim" || pixels == 0 || pixels == simulated) return;
    refuse({asked, made}, value(asked) + ", must be 0 or the size of the simulated images: [sim] " + value(made));
  }

  const Config& config_;
};

}  // namespace

bool Config::detects(std::string_view detector) const {
  const std::string_view words = main.detectors;
  for (size_t i = 0; i <= words.size();) {
    const size_t comma = std::min(words.find(", ", i), words.size());
    if (words.substr(i, comma - i) == detector) return true;
    i = comma + 2;
  }
  return false;
}

std::vector<Contradiction> check(const Config& config) {
  Check check(config);
  check.name();
  check.cpus();
  check.files();
  check.mosaic();
  check.recorder();
  check.sizes();
  check.search();
  check.floor();
  check.angle();
  check.snow();
  check.decide();
  check.cells("Map.range", config.map.range);
  check.cells("Map.width", config.map.width);
  return std::move(check.found);
}

}  // namespace vdisp
