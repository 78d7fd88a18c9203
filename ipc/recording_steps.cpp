// recording_steps.cpp: inputs.csv: one list of columns, for writing and for reading.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstring>

#include "ipc/recording_text.h"

namespace vdisp::recording {
namespace {

/// Calls visit(prefix, name, value) for each column in its order. `Step` is const for writing.
template <class Step, class Visit>
class Columns {
 public:
  Columns(Step& step, Visit& visit) {
    visit("", "sequence", step.sequence);
    visit("", "timestamp_ns", step.timestamp_ns);
    visit("", "reason", step.reason);
    visit("", "flags", step.flags);
    visit("", "config_generation", step.config_generation);
    auto& o = step.odometry.record;
    head("odometry.", step.odometry, visit);
    visit("odometry.", "measured_ns", o.timestamp_ns);
    visit("odometry.", "x", o.x), visit("odometry.", "y", o.y), visit("odometry.", "z", o.z);
    visit("odometry.", "roll", o.roll), visit("odometry.", "pitch", o.pitch), visit("odometry.", "yaw", o.yaw);
    visit("odometry.", "speed", o.speed), visit("odometry.", "turn_rate", o.turn_rate);
    visit("odometry.", "position_deviation", o.position_deviation), visit("odometry.", "yaw_deviation", o.yaw_deviation);
    visit("odometry.", "frame", o.frame);
    auto& i = step.imu.record;
    head("imu.", step.imu, visit);
    visit("imu.", "measured_ns", i.timestamp_ns);
    visit("imu.", "ax", i.acceleration[0]), visit("imu.", "ay", i.acceleration[1]), visit("imu.", "az", i.acceleration[2]);
    visit("imu.", "wx", i.rate[0]), visit("imu.", "wy", i.rate[1]), visit("imu.", "wz", i.rate[2]);
    visit("imu.", "roll", i.roll), visit("imu.", "pitch", i.pitch);
    head("drive.", step.drive, visit);
    visit("drive.", "measured_ns", step.drive.record.timestamp_ns);
    visit("drive.", "speed", step.drive.record.speed), visit("drive.", "turn_rate", step.drive.record.turn_rate);
    head("event.", step.event, visit);
    visit("event.", "count", step.event.record.count);
  }

 private:
  template <class Input>
  void head(const char* of, Input& input, Visit& visit) {
    visit(of, "reason", input.reason);
    visit(of, "flags", input.flags);
    visit(of, "timestamp_ns", input.timestamp_ns);
    visit(of, "age_s", input.record.age_s);
    visit(of, "accepted", input.record.tally.accepted);
    visit(of, "refused", input.record.tally.refused);
    visit(of, "last_refusal", input.record.tally.last_refusal);
    visit(of, "in_step", input.record.tally.in_step);
  }
};

struct Naming {
  std::string text;
  template <class Value>
  void operator()(const char* of, const char* name, const Value&) {
    text.append(of).append(name) += ',';
  }
};

struct Writing {
  std::string text;
  void operator()(const char*, const char*, Reason reason) { text.append(name(reason)) += ','; }
  void operator()(const char*, const char*, Refusal refusal) { text.append(name(refusal)) += ','; }
  template <class Number>
  void operator()(const char*, const char*, Number value) {
    char digits[40];
    const bool none = std::is_floating_point_v<Number> && value != value;
    if (!none) text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    text += ',';
  }
};

struct Parsing {
  const Lines& lines;
  std::string_view& line;
  std::string field;

  [[noreturn]] void refuse(const char* of, const char* what, const std::string& right) const {
    lines.refuse(std::string(of) + what + " = '" + field + "', must be " + right);
  }
  void take(const char* of, const char* what) {
    if (!next_field(line, field)) lines.refuse(std::string(of) + what + ": a quote does not end");
  }
  template <class Word>
  void word(const char* of, const char* what, Word& value) {
    take(of, what);
    for (uint32_t i = 0; i < static_cast<uint32_t>(Word::count); ++i) {
      value = static_cast<Word>(i);
      if (name(value) == field) return;
    }
    refuse(of, what, "a reason as wire-format.md has them");
  }
  void operator()(const char* of, const char* what, Reason& value) { word(of, what, value); }
  void operator()(const char* of, const char* what, Refusal& value) { word(of, what, value); }
  template <class Number>
  void operator()(const char* of, const char* what, Number& value) {
    take(of, what);
    if constexpr (std::is_floating_point_v<Number>) {
      value = std::nan("");
      if (field.empty()) return;
    }
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size()) refuse(of, what, "a number");
  }
};

template <class Input>
void set_header(Input& input) {
  using Record = decltype(input.record);
  input.record.header = {Record::type, Record::version, sizeof(Record)};
}

/// The rest of the line: time and label of each event, the oldest first.
void take_events(const Lines& lines, std::string_view line, const Events* before, Events& events) {
  if (events.count > Events::capacity) lines.refuse("event.count = " + std::to_string(events.count) + ", at most 8 are kept");
  if (before) std::copy(std::begin(before->entries), std::end(before->entries), events.entries);
  uint32_t taken = 0;
  for (std::string field; !line.empty(); ++taken) {
    Events::Entry entry{};
    if (!next_field(line, field) || line.empty()) lines.refuse("events at the end of the line must be a time and a label each");
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), entry.timestamp_ns);
    if (error != std::errc() || end != field.data() + field.size()) lines.refuse("an event's time is '" + field + "', must be a number");
    if (!next_field(line, field)) lines.refuse("a quote does not end");
    const bool printable = std::all_of(field.begin(), field.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (field.empty() || field.size() >= sizeof entry.label || !printable)
      lines.refuse("an event's label must be 1 to 47 printable characters");
    std::memcpy(entry.label, field.data(), field.size());
    std::copy_backward(events.entries, events.entries + Events::capacity - 1, events.entries + Events::capacity);
    events.entries[0] = entry;
  }
  if (taken > Events::capacity) lines.refuse(std::to_string(taken) + " events in a step, at most 8 are kept");
  std::fill(events.entries + events.count, std::end(events.entries), Events::Entry{});
}

}  // namespace

std::string steps_head() {
  Naming naming;
  RecordedStep step;
  Columns<const RecordedStep, Naming>(step, naming);
  return naming.text + "events";
}

std::string step_line(const RecordedStep& step, bool all_events) {
  Writing writing;
  Columns<const RecordedStep, Writing>(step, writing);
  std::string text = std::move(writing.text);
  text.pop_back();
  const Events& events = step.event.record;
  const uint32_t count = std::min(events.count, Events::capacity);
  for (uint32_t i = all_events ? count : std::min(count, events.tally.in_step); i-- > 0;) {
    text.append(",").append(std::to_string(events.entries[i].timestamp_ns)).append(",\"");
    for (const char c : events.entries[i].text()) text.append(c == '"' ? 2 : 1, c);
    text += '"';
  }
  return text + "\n";
}

std::vector<RecordedStep> read_steps(const std::string& file, std::string_view text, size_t& cut_off) {
  Lines lines(file, text);
  lines.require_head(steps_head());
  std::vector<RecordedStep> steps;
  for (std::string_view line; lines.next(line);) {
    RecordedStep step;
    Parsing parsing{lines, line, {}};
    Columns<RecordedStep, Parsing>(step, parsing);
    set_header(step.odometry), set_header(step.imu), set_header(step.drive), set_header(step.event);
    if (!steps.empty() && step.sequence <= steps.back().sequence)
      lines.refuse("step " + std::to_string(step.sequence) + " is not after the line before");
    take_events(lines, line, steps.empty() ? nullptr : &steps.back().event.record, step.event.record);
    steps.push_back(step);
  }
  cut_off += lines.cut_off();
  return steps;
}

}  // namespace vdisp::recording
