// config.h: the parameters of vdisp.cfg as a struct, read from the file, checked, printed: all from schema.def.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdisp {

/// What a REAL_OR holds when the file has the word instead of a number.
inline constexpr double word_given = std::numeric_limits<double>::quiet_NaN();
namespace schema {
constexpr double real_or(double value) { return value; }
constexpr double real_or(const char*) { return word_given; }
}  // namespace schema

#define BEGIN(section, title, help) struct section##_section {
#define END(section) \
  }                  \
  ;
#define INT(section, key, initial, least, most, step, unit, when, help) int key = initial;
#define REAL(section, key, initial, least, most, unit, when, help) double key = initial;
#define REAL_OR(section, key, initial, least, most, word, unit, when, help) double key = schema::real_or(initial);
#define FLAG(section, key, initial, when, help) bool key = initial;
#define TEXT(section, key, initial, when, help) std::string key = initial;
#define PATH(section, key, initial, when, help) std::string key = initial;
#define CHOICE(section, key, initial, choices, when, help) std::string key = initial;
#include "config/schema.def"
#undef BEGIN
#undef END
#undef INT
#undef REAL
#undef REAL_OR
#undef FLAG
#undef TEXT
#undef PATH
#undef CHOICE

/// One member per section of the file; see schema.def for meaning, unit and range of each key.
struct Config {
  main_section main;
  image_source_section image_source;
  camera_section camera;
  mounting_section mounting;
  floor_section floor;
  limit_section limit;
  map_section map;
  ipc_section ipc;
  memory_section memory;
  census_section census;
  snow_section snow;
  decide_section decide;
  control_section control;
  recorder_section recorder;
  drive_section drive;
  sim_section sim;

  /// Whether the tree has this branch: vdisparity, snow.
  bool detects(std::string_view detector) const;
  bool automatic_pitch() const { return std::isnan(limit.angRot); }
  /// Expected pitch of the camera: [mounting] pitch, else the number in angRot; NaN where neither says.
  double expected_pitch() const { return std::isnan(mounting.pitch) ? limit.angRot : mounting.pitch; }
};

/// Something the operator should know: what was found, where, what would be right. Written as "file:line: text".
struct Complaint {
  std::string file;  ///< or the option: --set SECTION.KEY=VALUE
  int line = 0;      ///< 0: the whole file, or an option
  std::string text;
};
std::ostream& operator<<(std::ostream& out, const Complaint& complaint);

struct ConfigReading {
  std::vector<Complaint> complaints;
  std::vector<Complaint> notes;  ///< nothing wrong, but worth a line
  int exit_code = 0;             ///< of sysexits.h: 66 the file cannot be read, 77 it may not, 78 it is wrong
};

/// Defaults, then the file, then each SECTION.KEY=VALUE. An empty path is no file. All complaints at once; with any, `config`
/// stays as it was.
ConfigReading read_config(const std::filesystem::path& path, std::span<const std::string> sets, Config& config);

/// Values that are each in their range, but not together.
struct Contradiction {
  std::vector<std::string> parameters;  ///< "Floor.anglefloorMin": those that contradict each other
  std::string text;
};
std::vector<Contradiction> check(const Config& config);

/// A vdisp.cfg with every key, its help, range and default; what differs from the default is marked. Reads back to the same
/// Config.
void print_config(std::ostream& out, const Config& config);

}  // namespace vdisp
