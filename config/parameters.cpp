// parameters.cpp: the table made from schema.def; text to value and back.
// SPDX-License-Identifier: Apache-2.0
#include "config/parameters.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "config/quoting.h"

namespace vdisp {
namespace {

constexpr size_t longest_text = 4000;  // so that the line fits the reader, every character escaped

// std::from_chars: the same in every locale; whatever follows the number is refused.
template <class T>
std::optional<T> number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <class T>
std::string shortest(T value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

std::vector<std::string_view> split(std::string_view words) {
  std::vector<std::string_view> parts;
  for (;;) {
    const size_t bar = words.find('|');
    parts.push_back(words.substr(0, bar));
    if (bar == words.npos) return parts;
    words.remove_prefix(bar + 1);
  }
}

std::string one_of(const std::vector<std::string_view>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

/// A choice may be a list: blanks around its commas do not matter.
bool same_list(std::string_view word, std::string_view text) {
  const auto plain = [](std::string_view list) {
    std::string kept;
    for (size_t i = 0; i < list.size(); ++i) {
      const bool beside_comma = (i > 0 && kept.ends_with(',')) || list.find_first_not_of(" \t", i) == list.find(',', i);
      if (!(is_blank(list[i]) && beside_comma)) kept += list[i];
    }
    return kept;
  };
  return word == text || plain(word) == plain(text);
}

std::optional<bool> yes_or_no(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  for (const char* yes : {"yes", "true", "on", "1"})
    if (lower == yes) return true;
  for (const char* no : {"no", "false", "off", "0"})
    if (lower == no) return false;
  return std::nullopt;
}

bool in_range(const Parameter& row, double value) { return value >= row.least && value <= row.most; }

bool parse(const Parameter& row, std::string_view text, int& value) {
  const auto found = number<int>(text);
  if (!found || !in_range(row, *found) || (*found - int(row.least)) % row.step != 0) return false;
  value = *found;
  return true;
}

bool parse(const Parameter& row, std::string_view text, double& value) {
  if (!row.words.empty() && text == row.words) {
    value = word_given;
    return true;
  }
  const auto found = number<double>(text);
  if (!found || !in_range(row, *found)) return false;  // false for NaN too
  value = *found;
  return true;
}

bool parse(const Parameter&, std::string_view text, bool& value) {
  const auto found = yes_or_no(text);
  if (found) value = *found;
  return found.has_value();
}

bool parse(const Parameter& row, std::string_view text, std::string& value) {
  if (row.kind == Kind::choice) {
    const auto words = split(row.words);
    const auto found = std::find_if(words.begin(), words.end(), [&](std::string_view word) { return same_list(word, text); });
    if (found == words.end()) return false;
    value = *found;
    return true;
  }
  if (text.size() > longest_text || std::any_of(text.begin(), text.end(), is_control)) return false;
  value = text;
  return true;
}

std::string write(const Parameter&, int value) { return shortest(value); }
std::string write(const Parameter& row, double value) { return std::isnan(value) ? std::string(row.words) : shortest(value); }
std::string write(const Parameter&, bool value) { return value ? "yes" : "no"; }
std::string write(const Parameter&, const std::string& value) { return value; }

std::string complaint(const Parameter& row, std::string_view text) {
  std::string allowed = row.allowed();
  // 12.5 is a number in the range all the same.
  if (row.kind == Kind::whole && !number<int>(text) && number<double>(text)) allowed.replace(0, 2, "a whole ");
  const std::string found = text.empty() ? " has no value" : " = " + printable(text);
  return std::string(row.key) + found + ", must be " + allowed + ", default " + row.default_text();
}

std::vector<Parameter> make_parameters() {
  std::vector<Parameter> table;
  std::string_view in;
#define BEGIN(section, title, help) in = title;
#define END(section)
#define FIELD(section, key, type) [](Config& c) -> type& { return c.section.key; }
#define INT(section, key, initial, least, most, step, unit, when, help) \
  table.push_back({in, #key, help, unit, Kind::whole, When::when, FIELD(section, key, int), least, most, step, ""});
#define REAL(section, key, initial, least, most, unit, when, help) \
  table.push_back({in, #key, help, unit, Kind::real, When::when, FIELD(section, key, double), least, most, 1, ""});
#define REAL_OR(section, key, initial, least, most, word, unit, when, help) \
  table.push_back({in, #key, help, unit, Kind::real, When::when, FIELD(section, key, double), least, most, 1, word});
#define FLAG(section, key, initial, when, help) \
  table.push_back({in, #key, help, "", Kind::flag, When::when, FIELD(section, key, bool), 0, 0, 1, ""});
#define TEXT(section, key, initial, when, help) \
  table.push_back({in, #key, help, "", Kind::text, When::when, FIELD(section, key, std::string), 0, 0, 1, ""});
#define PATH(section, key, initial, when, help) \
  table.push_back({in, #key, help, "", Kind::path, When::when, FIELD(section, key, std::string), 0, 0, 1, ""});
#define CHOICE(section, key, initial, choices, when, help) \
  table.push_back({in, #key, help, "", Kind::choice, When::when, FIELD(section, key, std::string), 0, 0, 1, choices});
#include "config/schema.def"
#undef BEGIN
#undef END
#undef FIELD
#undef INT
#undef REAL
#undef REAL_OR
#undef FLAG
#undef TEXT
#undef PATH
#undef CHOICE
  return table;
}

}  // namespace

std::string Parameter::name() const { return std::string(section) + "." + std::string(key); }

std::string Parameter::allowed() const {
  switch (kind) {
    case Kind::flag: return "yes or no";
    case Kind::text: return "a text of one line";
    case Kind::path: return "a path of one line";
    case Kind::choice: return one_of(split(words));
    case Kind::whole:
    case Kind::real: break;
  }
  const auto edge = [this](double value) { return kind == Kind::whole ? shortest(int(value)) : shortest(value); };
  std::string text = "a number from " + edge(least) + " to " + edge(most);
  if (step != 1) text += " in steps of " + shortest(step);
  text += " [" + std::string(unit) + "]";
  return words.empty() ? text : text + " or " + std::string(words);
}

std::string Parameter::default_text() const {
  const std::string text = get(Config{});
  return kind == Kind::text || kind == Kind::path ? in_quotes(text) : text;
}

std::string Parameter::get(const Config& config) const {
  // The fields are references to what may be written; here they are only read.
  Config& readable = const_cast<Config&>(config);
  return std::visit([&](auto at) { return write(*this, at(readable)); }, field);
}

std::optional<std::string> Parameter::set(Config& config, std::string_view text) const {
  const bool good = std::visit([&](auto at) { return parse(*this, text, at(config)); }, field);
  if (!good) return complaint(*this, text);
  if (key == "angRot") config.limit.angRot = config.map.angRot = std::get<double& (*)(Config&)>(field)(config);
  return std::nullopt;
}

void Parameter::exchange(Config& one, Config& other) const noexcept {
  if (key == "angRot") {
    std::swap(one.limit.angRot, other.limit.angRot);
    std::swap(one.map.angRot, other.map.angRot);
    return;
  }
  std::visit([&](auto at) { std::swap(at(one), at(other)); }, field);
}

std::span<const Section> sections() {
  static const Section table[] = {
#define BEGIN(section, title, help) {title, help},
#define END(section)
#define INT(...)
#define REAL(...)
#define REAL_OR(...)
#define FLAG(...)
#define TEXT(...)
#define PATH(...)
#define CHOICE(...)
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
  };
  return table;
}

std::span<const Parameter> parameters() {
  static const std::vector<Parameter> table = make_parameters();
  return table;
}

const Parameter* find_parameter(std::string_view section, std::string_view key) {
  for (const Parameter& row : parameters())
    if (row.section == section && row.key == key) return &row;
  return nullptr;
}

const Parameter* find_parameter(std::string_view name) {
  const size_t dot = name.rfind('.');
  return dot == name.npos ? nullptr : find_parameter(section_name(name.substr(0, dot)), name.substr(dot + 1));
}

std::string section_name(std::string_view given) {
  for (const Section& section : sections()) {
    std::string underscored(section.name);
    std::replace(underscored.begin(), underscored.end(), ' ', '_');
    if (given == underscored) return std::string(section.name);
  }
  return std::string(given);
}

}  // namespace vdisp
