// config_fuzz.cpp: any text as vdisp.cfg: refused with complaints of one line, or read, printed, rewritten and merged without loss.
// SPDX-License-Identifier: Apache-2.0
//
// Behind the first line of = signs stand SECTION.KEY=VALUE, one a line: options of the command line, and what is set by hand and saved.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

#include "config/change.h"
#include "daemon/control/reload.h"
#include "tests/fuzz/require.h"

namespace vdisp {
namespace {

constexpr const char* between = "\n=====\n";

/// A file in memory, and its name.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("vdisp.cfg", MFD_CLOEXEC)) {}
  std::string write(const std::string& text) const {
    const bool written = ftruncate(file_, 0) == 0 && pwrite(file_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
    require(written, "memory for a file");
    return "/proc/self/fd/" + std::to_string(file_);
  }

 private:
  int file_;
};

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const size_t end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
  }
  return lines;
}

/// All keys that differ, angRot once.
std::vector<const Parameter*> differences(const Config& a, const Config& b) {
  std::vector<const Parameter*> rows;
  for (const Parameter& row : parameters())
    if (row.get(a) != row.get(b) && !(row.key == "angRot" && row.section == "Map")) rows.push_back(&row);
  return rows;
}

ConfigReading read(const std::string& text, const std::vector<std::string>& options, Config& config) {
  static const MemoryFile file;
  const Config before = config;
  ConfigReading reading = read_config(file.write(text), options, config);
  require(reading.complaints.empty() == (reading.exit_code == 0), "a complaint has an exit code");
  require(reading.complaints.size() <= 101, "complaints come to an end");
  for (const auto* lines : {&reading.complaints, &reading.notes})
    for (const Complaint& complaint : *lines) require(is_one_line(complaint.text), "a complaint is one line: " + complaint.text);
  if (reading.complaints.empty())
    require(check(config).empty(), "what is read does not contradict itself");
  else
    require(differences(before, config).empty(), "a refused file changes nothing");
  return reading;
}

std::string first(const ConfigReading& reading) { return reading.complaints.empty() ? "" : reading.complaints[0].text; }

/// Lines of the file that are not the key's own stand in the new one, in their order.
void require_kept(const std::string& before, const std::string& after, const Parameter& row) {
  const std::vector<std::string> old = lines_of(before), now = lines_of(after);
  size_t at = 0;
  for (const std::string& line : old) {
    const size_t found = static_cast<size_t>(std::find(now.begin() + static_cast<std::ptrdiff_t>(at), now.end(), line) - now.begin());
    const bool own = line.find(row.key) != line.npos || (row.key == "corrsize" && line.find("coorsize") != line.npos);
    require(found < now.size() || own, "save keeps the line '" + line + "'");
    if (found < now.size()) at = found + 1;
  }
}

/// set, save, and the file read again.
void save(const std::string& text, const Config& config, std::string_view option) {
  const size_t equals = option.find('=');
  std::string complaint;
  const Parameter* row = equals == option.npos ? nullptr : named_parameter(option.substr(0, equals), complaint);
  if (!row) return require(equals == option.npos || is_one_line(complaint), "an unknown key is told in one line");
  Config wanted = config;
  complaint = change(wanted, *row, option.substr(equals + 1));
  if (!complaint.empty()) {
    require(is_one_line(complaint), "a refusal is one line: " + complaint);
    return require(differences(config, wanted).empty(), "a refused value changes nothing");
  }
  if (row->when == When::restart) return;
  const std::string saved = rewritten(text, std::vector<std::pair<const Parameter*, std::string>>{{row, row->get(wanted)}});
  require_kept(text, saved, *row);
  Config back;
  const ConfigReading reading = read(saved, {}, back);
  // A line can become too long for the reader, as can the file: that save says so, and is not done.
  if (reading.complaints.empty())
    require(differences(back, wanted).empty(), "what is saved reads back");
  else
    require(saved.size() > 8000, "what is saved can be read: " + first(reading));
  Config running = config;
  const Reload reload = merge(config, wanted, running, Precedence::hand);
  require(reload.fault.empty() && reload.restart.empty() && reload.taken.size() == differences(config, wanted).size(),
          "a live key is taken");
  require(differences(running, wanted).empty(), "what is taken is in use");
}

void try_text(const std::string& text, const std::vector<std::string>& options) {
  Config config;
  const ConfigReading reading = read(text, {}, config);
  Config with_options;
  const ConfigReading both = read(text, options, with_options);
  if (!reading.complaints.empty()) return;
  require(rewritten(text, {}) == text, "saved without changes it is the same file");
  std::ostringstream printed;
  print_config(printed, config);
  Config back;
  const ConfigReading again = read(printed.str(), {}, back);
  require(again.complaints.empty(), "what is printed can be read: " + first(again));
  require(differences(config, back).empty(), "what is printed reads back");
  for (const std::string& option : options) save(text, config, option);
  if (!both.complaints.empty()) return;
  for (const Precedence precedence : {Precedence::file, Precedence::hand}) {
    Config running = config;
    const Reload reload = merge(config, with_options, running, precedence);
    require(check(running).empty(), "what runs does not contradict itself");
    const size_t changed = differences(config, running).size();
    require(reload.fault.empty() ? changed == reload.taken.size() : is_one_line(reload.fault) && changed == 0, "all is taken, or nothing");
  }
}

}  // namespace
}  // namespace vdisp

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > (1 << 16)) return 0;
  const std::string_view whole(reinterpret_cast<const char*>(data), size);
  const size_t end = whole.find(vdisp::between);
  const std::string text(whole.substr(0, end == whole.npos ? end : end + 1));
  std::vector<std::string> options;
  if (end != whole.npos) options = vdisp::lines_of(whole.substr(end + std::string_view(vdisp::between).size()));
  if (options.size() > 4) options.resize(4);
  vdisp::try_text(text, options);
  return 0;
}
