// recording_text.h: the texts of a recording, in both directions; for ipc/recording*.cpp and their tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ipc/recording.h"

namespace vdisp::recording {

/// Readers throw RecordingError, which begins with `file`, and the line where there is one. A last line without an end is left out, and
/// counted in `cut_off`.
inline constexpr const char* index_head = "timestamp_ns,label,left,right,speed,turn_rate";
std::string index_line(const RecordedPair& pair);
std::vector<RecordedPair> read_index(const std::string& file, std::string_view text, size_t& cut_off);

std::string steps_head();
/// `all_events`: of a step whose forerunner is not in the file; else those that are new in it.
std::string step_line(const RecordedStep& step, bool all_events);
std::vector<RecordedStep> read_steps(const std::string& file, std::string_view text, size_t& cut_off);

std::string info_text(const RecordingInfo& info);
RecordingInfo read_info(const std::string& file, const std::string& text);

/// A CSV, line by line.
class Lines {
 public:
  Lines(std::string file, std::string_view text) : file_(std::move(file)), rest_(text) {}
  /// False at the end, and before a line without an end: then cut_off() is true.
  bool next(std::string_view& line);
  bool cut_off() const { return !rest_.empty(); }
  [[noreturn]] void refuse(const std::string& what) const;
  /// The first line must be this one.
  void require_head(const std::string& head);

 private:
  std::string file_;
  std::string_view rest_;
  size_t number_ = 0;
};
/// Cuts the first field off; quotes are taken off. False: a quote that does not end.
bool next_field(std::string_view& line, std::string& field);

}  // namespace vdisp::recording
