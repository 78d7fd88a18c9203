// change.cpp: one parameter by its name; the file with new values, line by line.
// SPDX-License-Identifier: Apache-2.0
#include "config/change.h"

#include <algorithm>
#include <vector>

#include "config/quoting.h"
#include "config/suggestion.h"

namespace vdisp {
namespace {

/// One line of the file: where its value stands, if it has one.
struct Line {
  std::string_view text;
  std::string section, key;  ///< key empty: no value
  size_t value_begin = 0, value_end = 0;
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  std::string section;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    Line line{text.substr(0, end), {}, {}};
    text.remove_prefix(end);
    std::string_view shown = line.text.substr(0, line.text.find_last_not_of("\r\n") + 1);
    if (lines.empty() && shown.starts_with(byte_order_mark)) shown.remove_prefix(byte_order_mark.size());
    const std::string_view body = without_comment(trimmed(shown));
    const size_t separator = body.find_first_of(separators);
    if (!body.empty() && body[0] == '[') {
      section = std::string(trimmed(body.substr(1, std::max<size_t>(body.find(']'), 1) - 1)));
    } else if (separator != body.npos) {
      line.key = std::string(trimmed(body.substr(0, separator)));
      const std::string_view value = trimmed(body.substr(separator + 1));
      line.value_begin = static_cast<size_t>((value.empty() ? body.data() + body.size() : value.data()) - line.text.data());
      line.value_end = line.value_begin + value.size();
    }
    line.section = section;
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string written(const Parameter& row, const std::string& value) {
  return row.kind == Kind::text || row.kind == Kind::path ? in_quotes(value) : value;
}

/// Texts of lines, with one more behind the last value of the section, or a new section at the end.
void append(std::vector<std::string>& texts, const std::vector<Line>& lines, const Parameter& row, const std::string& value) {
  const std::string text = std::string(row.key) + " = " + written(row, value) + "\n";
  size_t place = texts.size();
  for (size_t i = 0; i < lines.size(); ++i)
    if (lines[i].section == row.section && (!lines[i].key.empty() || trimmed(lines[i].text).starts_with('['))) place = i;
  const bool new_section = place == texts.size();
  if (!texts.empty()) {
    std::string& before = texts[new_section ? texts.size() - 1 : place];
    if (before.empty() || before.back() != '\n') before += '\n';
  }
  if (new_section) {
    texts.push_back((texts.empty() ? "[" : "\n[") + std::string(row.section) + "]\n" + text);
  } else {
    texts[place] += text;
  }
}

}  // namespace

const Parameter* named_parameter(std::string_view name, std::string& complaint) {
  if (const Parameter* row = find_parameter(name)) return row;
  const size_t dot = name.rfind('.');
  if (dot == name.npos) {
    const Parameter* found = nullptr;
    for (const Parameter& row : parameters()) {
      if (row.key != name || (found && row.key == "angRot")) continue;
      if (found) {
        complaint = std::string(name) + " stands in " + sections_with(name) + ", must be SECTION.KEY";
        return nullptr;
      }
      found = &row;
    }
    if (found) return found;
    complaint = "no parameter '" + printable(name) + "', must be SECTION.KEY, such as \"image source.thresh\"; vdisp-probe get lists all";
    return nullptr;
  }
  const std::string section = section_name(name.substr(0, dot));
  const bool known = std::any_of(sections().begin(), sections().end(), [&](const Section& s) { return s.name == section; });
  complaint = known ? unknown_key(section, name.substr(dot + 1)) : unknown_section(section);
  return nullptr;
}

std::string change(Config& config, const Parameter& row, std::string_view raw) {
  const Unquoted value = unquoted(trimmed(raw), row.kind == Kind::path);
  if (!value.error.empty()) return std::string(row.key) + " = " + printable(raw) + ", " + value.error;
  Config changed = config;
  if (const auto complaint = row.set(changed, value.text)) return *complaint;
  const std::vector<Contradiction> contradictions = check(changed);
  if (!contradictions.empty()) return contradictions[0].text;
  config = std::move(changed);
  return {};
}

std::string rewritten(std::string_view text, std::span<const std::pair<const Parameter*, std::string>> values) {
  std::string result(text);
  for (const auto& [row, value] : values) {
    const std::string before = std::move(result);
    const std::vector<Line> lines = lines_of(before);
    std::vector<std::string> texts;
    bool found = false;
    for (const Line& line : lines) {
      texts.emplace_back(line.text);
      const bool same = line.key == row->key && (line.section == row->section || row->key == "angRot");
      if (!same) continue;
      texts.back().replace(line.value_begin, line.value_end - line.value_begin, written(*row, value));
      found = true;
    }
    if (!found) append(texts, lines, *row, value);
    result.clear();
    for (const std::string& line : texts) result += line;
  }
  return result;
}

}  // namespace vdisp
