// recording_text.cpp: index.csv and recording.json.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/recording_text.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

namespace vdisp {
namespace {

constexpr std::string_view labels[] = {"none", "forward", "left", "right"};
static_assert(std::size(labels) == static_cast<size_t>(Label::count));

}  // namespace

std::string_view name(Label label) { return label < Label::count ? labels[static_cast<size_t>(label)] : "unknown"; }

Label label_of(Steering steering) {
  switch (steering) {
    case Steering::forward: return Label::forward;
    case Steering::turn_left: return Label::left;
    case Steering::turn_right: return Label::right;
    case Steering::count: break;
  }
  return Label::none;
}

Label label_of(double speed, double turn_rate) {
  if (turn_rate > least_turn) return Label::left;
  if (turn_rate < -least_turn) return Label::right;
  return speed > 0 ? Label::forward : Label::none;
}

std::string picture_name(std::string_view side, const RecordedPair& pair) {
  return std::string(side) + "/" + std::to_string(pair.timestamp_ns) + "_" + std::string(name(pair.label)) + ".png";
}

namespace recording {
namespace {

constexpr int version = 1, largest = 8192;  // px, as [image source] width
constexpr const char* format = "vdisp recording";

template <class Number>
bool parse(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

/// Shortest digits that read back to the same number; nothing for NaN.
std::string digits(double value) {
  if (std::isnan(value)) return {};
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

RecordedPair read_pair(const Lines& lines, std::string_view line) {
  if (std::count(line.begin(), line.end(), ',') != 5) lines.refuse("must be the six fields " + std::string(index_head));
  std::string fields[6];
  for (std::string& field : fields)
    if (!next_field(line, field)) lines.refuse("a quote does not end");
  RecordedPair pair;
  if (!parse(fields[0], pair.timestamp_ns) || pair.timestamp_ns < 0 || std::to_string(pair.timestamp_ns) != fields[0])
    lines.refuse("timestamp_ns = '" + fields[0] + "', must be a whole number from 0");
  const auto* const label = std::find(std::begin(labels), std::end(labels), fields[1]);
  if (label == std::end(labels)) lines.refuse("label '" + fields[1] + "' is unknown, must be forward, left, right or none");
  pair.label = static_cast<Label>(label - std::begin(labels));
  for (const int side : {2, 3}) {
    const std::string wanted = picture_name(side == 2 ? "left" : "right", pair);
    if (fields[side] != wanted) lines.refuse("the picture is called '" + fields[side] + "', by time and label it must be " + wanted);
  }
  const auto known = [&](const std::string& field, const char* what, double& value) {
    if (!field.empty() && (!parse(field, value) || !std::isfinite(value)))
      lines.refuse(std::string(what) + " = '" + field + "', must be a number, or empty");
  };
  known(fields[4], "speed", pair.speed);
  known(fields[5], "turn_rate", pair.turn_rate);
  return pair;
}

}  // namespace

bool Lines::next(std::string_view& line) {
  const size_t end = rest_.find('\n');
  if (end == std::string_view::npos) return false;
  line = rest_.substr(0, end);
  rest_.remove_prefix(end + 1);
  ++number_;
  return true;
}

void Lines::refuse(const std::string& what) const {
  std::string text = file_ + ", line " + std::to_string(number_) + ": " + what;
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  throw RecordingError(text);
}

void Lines::require_head(const std::string& head) {
  std::string_view line;
  if (next(line) && line == head) return;
  number_ = 1;
  refuse("found '" + std::string(line.substr(0, 60)) + "', must be " + head.substr(0, 60));
}

bool next_field(std::string_view& line, std::string& field) {
  field.clear();
  if (line.empty() || line[0] != '"') {
    const size_t end = std::min(line.find(','), line.size());
    field = line.substr(0, end);
    line.remove_prefix(std::min(end + 1, line.size()));
    return true;
  }
  for (size_t at = 1; at < line.size(); ++at) {
    if (line[at] != '"') {
      field += line[at];
    } else if (at + 1 < line.size() && line[at + 1] == '"') {
      field += line[at++];
    } else {
      if (at + 1 < line.size() && line[at + 1] != ',') return false;
      line.remove_prefix(std::min(at + 2, line.size()));
      return true;
    }
  }
  return false;
}

std::string index_line(const RecordedPair& pair) {
  return std::to_string(pair.timestamp_ns) + "," + std::string(name(pair.label)) + "," + picture_name("left", pair) + "," +
         picture_name("right", pair) + "," + digits(pair.speed) + "," + digits(pair.turn_rate) + "\n";
}

std::vector<RecordedPair> read_index(const std::string& file, std::string_view text, size_t& cut_off) {
  Lines lines(file, text);
  lines.require_head(index_head);
  std::vector<RecordedPair> pairs;
  for (std::string_view line; lines.next(line);) {
    pairs.push_back(read_pair(lines, line));
    if (pairs.size() > 1 && pairs.back().timestamp_ns <= pairs[pairs.size() - 2].timestamp_ns)
      lines.refuse("time " + std::to_string(pairs.back().timestamp_ns) + " is not after the line before");
  }
  cut_off += lines.cut_off();
  return pairs;
}

std::string info_text(const RecordingInfo& info) {
  const nlohmann::ordered_json json{
      {"format", format},  {"version", version},  {"program", info.program}, {"source", info.source}, {"world", info.world},
      {"seed", info.seed}, {"epoch", info.epoch}, {"width", info.width},     {"height", info.height}, {"synthetic", info.synthetic}};
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

RecordingInfo read_info(const std::string& file, const std::string& text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  const auto is = [&](const char* key, auto test) { return json.is_object() && json.contains(key) && test(json[key]); };
  const auto whole = [](const nlohmann::json& value) { return value.is_number_unsigned(); };
  if (!is("format", [](const auto& value) { return value == format; }))
    throw RecordingError(file + ": is no description of a recording, must be JSON with \"format\": \"" + format + "\"");
  if (!is("version", [](const auto& value) { return value == version; }))
    throw RecordingError(file + ": is of version " + (json.contains("version") ? json["version"].dump() : "none") + ", known is " +
                         std::to_string(version));
  RecordingInfo info;
  for (const auto& [key, pixels] : {std::pair{"width", &info.width}, std::pair{"height", &info.height}}) {
    if (!is(key, whole) || json[key] < 1 || json[key] > largest)
      throw RecordingError(file + ": " + key + " must be a whole number from 1 to " + std::to_string(largest));
    *pixels = json[key];
  }
  for (const auto& [key, word] : {std::pair{"program", &info.program}, std::pair{"source", &info.source}, std::pair{"world", &info.world}})
    if (is(key, [](const auto& value) { return value.is_string(); })) *word = json[key];
  if (is("seed", whole)) info.seed = json["seed"];
  if (is("epoch", whole)) info.epoch = json["epoch"];
  info.synthetic = is("synthetic", [](const auto& value) { return value == true; });
  return info;
}

}  // namespace recording
}  // namespace vdisp
