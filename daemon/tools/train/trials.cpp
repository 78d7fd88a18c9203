// trials.cpp: lines of a trial, read and appended.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/trials.h"

#include <fcntl.h>
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

constexpr const char* head =
    "encoding,size,width,block,smooth,confidence,thick,obstacle_auc,direction_auc,obstacle_sensitivity,direction_sensitivity";
constexpr size_t fields = 11;
constexpr const char* smooths[] = {"none", "mean", "median"};

std::string digits(double value) {
  std::array<char, 40> buffer;
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

std::string line_of(const Trial& t) {
  std::string line = std::string(name(t.settings.encoding)) + "," + std::to_string(t.settings.width) + "x" +
                     std::to_string(t.settings.height) + "," + std::to_string(t.settings.disparities) + "," +
                     std::to_string(t.settings.block) + "," + smooths[static_cast<size_t>(t.settings.smooth)];
  for (const double value :
       {t.settings.confidence, t.thick, t.obstacle_auc, t.direction_auc, t.obstacle_sensitivity, t.direction_sensitivity})
    line += "," + digits(value);
  return line;
}

template <class Number>
bool parse(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool parse_trial(const std::string& line, Trial& t) {
  std::vector<std::string> found;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) found.push_back(field);
  if (found.size() != fields) return false;
  const auto encoding = snow::encoding_named(found[0]);
  const size_t cross = found[1].find('x');
  const auto* const smooth = std::find(std::begin(smooths), std::end(smooths), found[4]);
  if (!encoding || cross == std::string::npos || smooth == std::end(smooths)) return false;
  t.settings.encoding = *encoding;
  t.settings.smooth = static_cast<snow::Smooth>(smooth - std::begin(smooths));
  return parse(found[1].substr(0, cross), t.settings.width) && parse(found[1].substr(cross + 1), t.settings.height) &&
         parse(found[2], t.settings.disparities) && parse(found[3], t.settings.block) && parse(found[5], t.settings.confidence) &&
         parse(found[6], t.thick) && parse(found[7], t.obstacle_auc) && parse(found[8], t.direction_auc) &&
         parse(found[9], t.obstacle_sensitivity) && parse(found[10], t.direction_sensitivity);
}

}  // namespace

TrialTable::TrialTable(std::string path, const std::string& question) : path_(std::move(path)) {
  std::string text;
  if (std::ifstream file(path_, std::ios::binary); file)
    text.assign(std::istreambuf_iterator<char>(file), {});
  else if (std::error_code error; std::filesystem::exists(path_, error))
    throw ToolError(EX_NOPERM, path_ + ": cannot be read; give another name with --table");
  // Cut off in its first line it is what such a line begins with, or nothing of ours.
  const std::string first = "# " + question + "\n";
  if (text.find('\n') == std::string::npos && first.compare(0, text.size(), text) != 0)
    throw ToolError(EX_CONFIG, path_ + ": no table of vdisp-train tune; give another name with --table");
  text.resize(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);  // what was cut off
  read(text, question);
  file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) throw ToolError(EX_CANTCREAT, path_ + ": cannot be written: " + std::strerror(errno));
  const std::string begin = text.empty() ? first + head + "\n" : "";
  const bool ready = ftruncate(file_, static_cast<off_t>(text.size())) == 0 && lseek(file_, 0, SEEK_END) >= 0 &&
                     write(file_, begin.data(), begin.size()) == static_cast<ssize_t>(begin.size());
  if (!ready) throw ToolError(EX_IOERR, path_ + ": cannot be written: " + std::strerror(errno));
}

TrialTable::~TrialTable() {
  if (file_ >= 0) close(file_);
}

void TrialTable::read(std::string text, const std::string& question) {
  std::istringstream lines(text);
  std::string line;
  if (!std::getline(lines, line)) return;
  if (line.rfind("# ", 0) != 0) throw ToolError(EX_CONFIG, path_ + ": no table of vdisp-train tune; give another name with --table");
  if (line != "# " + question)
    throw ToolError(EX_CONFIG, path_ + ": is of other recordings or another network: '" + line.substr(2) + "', asked is '" + question +
                                   "'; give another name with --table");
  for (int number = 2; std::getline(lines, line); ++number) {
    Trial trial;
    if (line == head) continue;
    if (!parse_trial(line, trial))
      throw ToolError(EX_CONFIG, path_ + ":" + std::to_string(number) + ": no trial: '" + line + "', needed is " + head);
    trials_.push_back(trial);
  }
}

bool TrialTable::has(const Trial& trial) const {
  return std::any_of(trials_.begin(), trials_.end(), [&](const Trial& known) { return known.same_question(trial); });
}

void TrialTable::add(const Trial& trial) {
  const std::string line = line_of(trial) + "\n";
  if (write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size()) || fdatasync(file_) != 0)
    throw ToolError(EX_IOERR, path_ + ": cannot be written: " + std::strerror(errno));
  trials_.push_back(trial);
}

std::string text_of(std::vector<Trial> trials) {
  std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.worth() > b.worth(); });
  std::array<char, 200> line;
  const auto format = "%-15s %5s %5s %-7s %10s %6s   %9s %10s   %9s %10s\n";
  std::snprintf(line.data(), line.size(), format, "encoding", "width", "block", "smooth", "confidence", "thick", "obstacle", "sensitiv.",
                "direction", "sensitiv.");
  std::string text = line.data();
  for (const Trial& t : trials) {
    std::snprintf(line.data(), line.size(), "%-15s %5u %5u %-7s %10g %6g   %9.4f %10.4f   %9.4f %10.4f\n",
                  std::string(name(t.settings.encoding)).c_str(), t.settings.disparities, t.settings.block,
                  smooths[static_cast<size_t>(t.settings.smooth)], t.settings.confidence, t.thick, t.obstacle_auc, t.obstacle_sensitivity,
                  t.direction_auc, t.direction_sensitivity);
    text += line.data();
  }
  return text;
}

}  // namespace vdisp::train
