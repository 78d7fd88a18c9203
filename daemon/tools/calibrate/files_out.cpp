// files_out.cpp: writes a calibration beside its place, reads it back, and renames it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/files_out.h"

#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <vector>

#include "daemon/tools/calibrate/words.h"
#include "ipc/png.h"

namespace vdisp::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr double tolerance = 1e-9;  // of each number; a file of 15 digits is far within it

std::vector<double> numbers(const Calibration& c) {
  std::vector<double> all{c.width * 1.0, c.height * 1.0, c.view.f, c.view.cx, c.view.cy, c.view.baseline, c.view.cx_offset};
  if (!c.raw) return all;
  for (const RawCamera& camera : *c.raw)
    for (const auto& [begin, size] : {std::pair{camera.k.data(), camera.k.size()},
                                      {camera.distortion.data(), camera.distortion.size()},
                                      {camera.rectification.data(), camera.rectification.size()},
                                      {camera.projection.data(), camera.projection.size()}})
      all.insert(all.end(), begin, begin + size);
  return all;
}

bool same(const Calibration& a, const Calibration& b) {
  const auto left = numbers(a), right = numbers(b);
  return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                    [](double x, double y) { return std::abs(x - y) <= tolerance * std::max(1.0, std::abs(x)); });
}

/// A hidden folder beside the place, gone with this.
class Workshop {
 public:
  explicit Workshop(const fs::path& parent) : path_(parent / (".vdisp-calibrate." + std::to_string(getpid()))) {
    if (std::error_code error; !fs::create_directory(path_, error)) throw write_error("cannot create", path_, error.value());
  }
  ~Workshop() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void move_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) throw write_error("cannot create", to, error.value());
}

}  // namespace

CalibrationFormat format_for(const fs::path& path, const std::string& format) {
  const std::string ending = path.extension().string();
  std::error_code ignored;
  if (format == "svs" || (format.empty() && ending == ".ini")) return CalibrationFormat::svs;
  if (format == "opencv" || (format.empty() && (ending == ".yml" || ending == ".yaml"))) return CalibrationFormat::opencv;
  if (format == "ros" || (format.empty() && (ending.empty() || fs::is_directory(path, ignored)))) return CalibrationFormat::ros;
  throw ToolError(EX_USAGE, path.string() + ": '" + ending + "' is no known ending; needed is .ini, .yml, .yaml, a folder, or --format");
}

Calibration read_input(const fs::path& path, const ReadingOptions& options) {
  if (std::error_code error; !fs::exists(path, error))
    throw ToolError(EX_NOINPUT, path.string() + ": no such file; needed is a calibration");
  return read_calibration(path, options);
}

void write_calibration(const Calibration& calibration, CalibrationFormat format, const fs::path& path) {
  const auto texts = calibration_texts(calibration, format);
  const bool folder = !texts[0].name.empty();
  if (std::error_code error; folder && !fs::is_directory(path, error) && !fs::create_directory(path, error))
    throw write_error("cannot create", path, error ? error.value() : ENOTDIR);
  const fs::path place = folder ? path : path.parent_path();
  const Workshop workshop(place.empty() ? "." : place);
  const auto name = [&](const CalibrationFile& text) { return folder ? fs::path(text.name) : path.filename(); };
  for (const CalibrationFile& text : texts) write_file(workshop.path() / name(text), text.content);
  if (!same(calibration, read_calibration(folder ? workshop.path() : workshop.path() / name(texts[0]))))
    throw std::logic_error("what was written reads back as something else");
  for (const CalibrationFile& text : texts) move_to(workshop.path() / name(text), folder ? path / text.name : path);
}

}  // namespace vdisp::calibrate
