// assignments.h: the values that a file and options give, put into a Config, with everything that is wrong with them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "config/parameters.h"

namespace vdisp {

/// Where a value was given: a line of the file, or an option.
struct Place {
  std::string file;
  int line = 0;
  int order = 0;
};

/// Values of the file come first, then options_begin(), then those of the options, which go before the file's.
class Assignments {
 public:
  /// `folder` is where relative paths begin.
  explicit Assignments(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void complain(const Place& place, std::string text);
  /// The file cannot be read at all.
  void fail(const Place& place, std::string text, int exit_code);
  void options_begin(std::filesystem::path folder);
  /// `section` is one of the table; `raw` is the value as it was written, quotes and all.
  void assign(const Place& place, std::string_view section, std::string_view key, std::string_view raw);
  /// Looks at everything together. `file` is blamed where nothing else can be.
  ConfigReading finish(const std::string& file, Config& config);

 private:
  bool is_repeated(const Parameter& row, const Place& place);
  void compare_angles(const Parameter& row, const std::string& before, const Place& place);
  void report_contradictions(const std::string& file);

  std::filesystem::path folder_;
  Config config_;
  ConfigReading result_;
  bool options_ = false;
  int count_ = 0;
  std::map<const Parameter*, Place> given_;        // by file or option, the later one
  std::map<const Parameter*, Place> given_there_;  // in the file, or among the options
  std::set<const Parameter*> wrong_;
};

}  // namespace vdisp
