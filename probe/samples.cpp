// samples.cpp: CSV lines to messages.
// SPDX-License-Identifier: Apache-2.0
#include "probe/samples.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <thread>
#include <utility>

#include "probe/attach.h"

namespace vdisp {
namespace {

std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(trimmed(field));
  return fields;
}

template <class Number>
bool parse(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ",") + word;
  return all;
}

}  // namespace

void require_done(const Control& control, const Options& options, const std::function<Control::Result()>& call) {
  const auto start = std::chrono::steady_clock::now();
  while (true) {
    const Control::Result result = call();
    if (result == Control::Result::done) return;
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
    if (result != Control::Result::no_daemon || waited.count() >= options.wait_s || stopped())
      throw ProbeError(exit_code(result), control.message());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

Samples::Samples(std::string kind) : kind_(std::move(kind)) {
  if (kind_ == "odometry") {
    known_ = {"x", "y", "yaw", "z", "roll", "pitch", "speed", "turn_rate"};
    needed_ = 3;
  } else if (kind_ == "imu") {
    known_ = {"ax", "ay", "az", "wx", "wy", "wz"};
    needed_ = 3;
  } else if (kind_ == "drive") {
    known_ = {"speed", "turn_rate"};
    needed_ = 2;
  } else {
    known_ = {"label"};
    needed_ = 1;
  }
  columns_ = known_;
}

/// The first line names the columns where it has one of their names.
bool Samples::take_names(const std::vector<std::string>& fields) {
  const auto is_name = [&](const std::string& field) {
    return field == "timestamp_ns" || std::find(known_.begin(), known_.end(), field) != known_.end();
  };
  if (std::none_of(fields.begin(), fields.end(), is_name)) return false;
  for (size_t i = 0; i < needed_; ++i)
    if (std::find(fields.begin(), fields.end(), known_[i]) == fields.end())
      throw ProbeError(66, "line " + std::to_string(count_) + ": '" + joined(fields) + "' lacks the column " + known_[i] + "; " + kind_ +
                               " has " + joined(known_) + " and timestamp_ns");
  columns_ = fields;
  return true;
}

std::optional<Samples::Line> Samples::read(const std::string& text) {
  ++count_;
  const std::string body = trimmed(text);
  if (body.empty() || body[0] == '#') return std::nullopt;
  const std::vector<std::string> fields = fields_of(body);
  if (std::exchange(first_, false) && take_names(fields)) return std::nullopt;
  const std::string where = "line " + std::to_string(count_) + ": ";
  const bool named = columns_ != known_;
  if (fields.size() > columns_.size() || fields.size() < (named ? columns_.size() : needed_))
    throw ProbeError(66, where + std::to_string(fields.size()) + " fields, must be " + joined(columns_));
  Line line{{}, std::vector<double>(known_.size(), not_known), {}};
  for (size_t i = 0; i < fields.size(); ++i) {
    const auto column = std::find(known_.begin(), known_.end(), columns_[i]);
    int64_t stamp = 0;
    if (columns_[i] == "timestamp_ns") {
      if (!parse(fields[i], stamp)) throw ProbeError(66, where + "timestamp_ns = '" + fields[i] + "', must be whole nanoseconds");
      line.timestamp_ns = stamp;
    } else if (columns_[i] == "label") {
      line.label = fields[i];
    } else if (column != known_.end() && !parse(fields[i], line.values[static_cast<size_t>(column - known_.begin())])) {
      throw ProbeError(66, where + columns_[i] + " = '" + fields[i] + "', must be a number");
    }
  }
  return line;
}

Control::Result Samples::send(Control& control, const Line& line, int64_t timestamp_ns) const {
  const std::vector<double>& v = line.values;
  if (kind_ == "odometry") return control.odometry({timestamp_ns, v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]});
  if (kind_ == "imu") return control.imu({timestamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  if (kind_ == "drive") return control.drive(v[0], v[1], timestamp_ns);
  return control.event(line.label, timestamp_ns);
}

}  // namespace vdisp
