// quoting.cpp: how a value is written in a line of vdisp.cfg: quotes, escapes, comments, $NAME.
// SPDX-License-Identifier: Apache-2.0
#include "config/quoting.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace vdisp {
namespace {

constexpr auto none = std::string_view::npos;

size_t find_comment(std::string_view line, size_t from) {
  for (size_t i = from; i < line.size(); ++i)
    if ((line[i] == '#' || line[i] == ';') && (i == 0 || is_blank(line[i - 1]))) return i;
  return none;
}

/// `open` is where the first quote stands; none if there is no second one.
size_t closing_quote(std::string_view line, size_t open) {
  const char quote = line[open];
  for (size_t i = open + 1; i < line.size(); ++i) {
    if (line[i] == quote) return i;
    if (quote == '"' && line[i] == '\\') ++i;
  }
  return none;
}

bool is_escape(std::string_view text, size_t at) {
  return text[at] == '\\' && at + 1 < text.size() && (text[at + 1] == '"' || text[at + 1] == '\\' || text[at + 1] == '$');
}

bool is_name(char c) { return c == '_' || std::isalnum(static_cast<unsigned char>(c)); }

/// Appends what the reference at text[at] stands for, and moves `at` past it. Gives what is wrong.
std::string append_reference(std::string_view text, size_t& at, std::string& out) {
  const bool braces = at + 1 < text.size() && text[at + 1] == '{';
  const size_t begin = at + (braces ? 2 : 1);
  size_t end = begin;
  while (end < text.size() && is_name(text[end])) ++end;
  const bool closed = !braces || (end < text.size() && text[end] == '}');
  if (end == begin || !closed) return "$ must begin $NAME or ${NAME}; a plain $ is written \"\\$\"";
  const std::string name(text.substr(begin, end - begin));
  const char* value = std::getenv(name.c_str());
  if (!value) return "$" + printable(name) + " is not in the environment; a plain $ is written \"\\$\"";
  out += value;
  at = end + (braces ? 1 : 0);
  return {};
}

Unquoted resolved(std::string_view text, bool escapes, bool references) {
  Unquoted result;
  for (size_t i = 0; i < text.size();) {
    if (escapes && is_escape(text, i)) {
      result.text += text[i + 1];
      i += 2;
    } else if (references && text[i] == '$') {
      result.error = append_reference(text, i, result.text);
      if (!result.error.empty()) return result;
    } else {
      result.text += text[i++];
    }
  }
  return result;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view without_comment(std::string_view line) {
  size_t comment = find_comment(line, 0);
  const size_t separator = line.find_first_of(separators);
  if (separator < comment) {
    size_t value = separator + 1;
    while (value < line.size() && is_blank(line[value])) ++value;
    if (value < line.size() && (line[value] == '"' || line[value] == '\'')) {
      const size_t close = closing_quote(line, value);
      comment = close == none ? none : find_comment(line, close + 1);
    }
  }
  return trimmed(line.substr(0, comment));
}

Unquoted unquoted(std::string_view raw, bool references) {
  if (raw.empty() || (raw[0] != '"' && raw[0] != '\'')) return resolved(raw, false, references);
  const size_t close = closing_quote(raw, 0);
  if (close == none) return {{}, std::string("the closing ") + raw[0] + " is missing"};
  if (close + 1 != raw.size()) {
    return {{}, "'" + printable(trimmed(raw.substr(close + 1))) + "' after the closing quote, must be nothing or a blank and a # comment"};
  }
  const bool plain = raw[0] == '\'';
  return resolved(raw.substr(1, close - 1), !plain, references && !plain);
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '$') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string printable(std::string_view text) {
  size_t length = std::min<size_t>(text.size(), 80);
  // Not in the middle of an UTF-8 character.
  while (length > 0 && length < text.size() && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
  std::string out(text.substr(0, length));
  std::replace_if(out.begin(), out.end(), is_control, '?');
  return length < text.size() ? out + "..." : out;
}

}  // namespace vdisp
