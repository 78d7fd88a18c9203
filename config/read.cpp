// read.cpp: reads vdisp.cfg with inih, and --set, and collects everything that is wrong with them.
// SPDX-License-Identifier: Apache-2.0
#include <ini.h>
#include <sysexits.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "config/assignments.h"
#include "config/quoting.h"
#include "config/suggestion.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr size_t longest_file = 1 << 20;
constexpr size_t longest_line = 8192;

bool is_section(std::string_view name) {
  return std::any_of(sections().begin(), sections().end(), [name](const Section& s) { return s.name == name; });
}

/// Gives inih the file line by line, and knows which line a key stands in.
class Reader {
 public:
  explicit Reader(Assignments& values, const fs::path& path) : values_(values), file_(path.string()) {}
  void read();

 private:
  static char* next_line(char* to, int size, void* self) { return static_cast<Reader*>(self)->next_line(to, size); }
  static int take(void* self, const char* section, const char* key, const char* value) {
    return static_cast<Reader*>(self)->take(section, key, value);
  }
  char* next_line(char* to, int size);
  int take(std::string_view section, std::string_view key, std::string_view value);

  std::string load();
  std::string prepare(std::string_view line);
  std::string begin_section(std::string_view line);
  void close_line();
  void complain(std::string text) { values_.complain(here(), std::move(text)); }
  Place here() const { return {file_, line_}; }

  Assignments& values_;
  std::string file_, content_;
  size_t position_ = 0;
  int line_ = 0;
  bool ended_ = false;
  bool open_line_ = false;     // a line that inih has not made a key and a value of
  bool skip_section_ = false;  // keys of a section that is not known cannot be judged
};

std::string Reader::load() {
  errno = 0;
  const std::unique_ptr<FILE, int (*)(FILE*)> file(std::fopen(file_.c_str(), "rb"), &std::fclose);
  std::string content;
  if (file) {
    char block[4096];
    for (size_t size = 1; size > 0 && content.size() <= longest_file; content.append(block, size))
      size = std::fread(block, 1, sizeof block, file.get());
  }
  if (!file || std::ferror(file.get())) {
    const int error = errno;
    values_.fail(here(), "cannot be read: " + std::generic_category().message(error) + "; must be a vdisp.cfg",
                 error == EACCES || error == EPERM ? EX_NOPERM : EX_NOINPUT);
    return {};
  }
  if (content.size() > longest_file) {
    complain("has more than 1 MiB, must be a vdisp.cfg");
    return {};
  }
  return content;
}

void Reader::read() {
  content_ = load();
  // Inih would take an indented line for more of the value above, and cut 200 characters; comments are cut in prepare().
  ini_allow_multiline = false;
  ini_allow_inline_comments = false;
  ini_stop_on_first_error = false;
  ini_max_line = static_cast<int>(longest_line) + 3;
  ini_parse_stream(&Reader::next_line, this, &Reader::take, this);
}

/// inih asks for the next line here: it does not tell its handler which line a key stands in.
char* Reader::next_line(char* to, int size) {
  close_line();
  if (ended_ || position_ >= content_.size()) return nullptr;
  const size_t end = std::min(content_.find('\n', position_), content_.size());
  std::string_view line(content_.data() + position_, end - position_);
  position_ = end + 1;
  ++line_;
  if (line_ == 1 && line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
  const std::string text = prepare(line);
  std::snprintf(to, static_cast<size_t>(size), "%s\n", text.c_str());
  return to;
}

/// What of the line inih is to see.
std::string Reader::prepare(std::string_view line) {
  const auto odd = std::find_if(line.begin(), line.end(), [](char c) { return is_control(c) && !is_blank(c); });
  if (odd != line.end()) {
    char code[8];
    std::snprintf(code, sizeof code, "0x%02x", static_cast<unsigned char>(*odd));
    complain(std::string("byte ") + code + " at column " + std::to_string(odd - line.begin() + 1) +
             ", must be text; the rest of the file was not read");
    ended_ = true;
    return {};
  }
  if (line.size() > longest_line) {
    complain("line of " + std::to_string(line.size()) + " characters, must have at most " + std::to_string(longest_line));
    return {};
  }
  const std::string_view text = without_comment(trimmed(line));
  if (text.empty()) return {};
  if (text[0] == '[') return begin_section(text);
  open_line_ = true;
  return std::string(text);
}

std::string Reader::begin_section(std::string_view line) {
  const size_t close = line.find(']');
  skip_section_ = true;
  if (close == line.npos) {
    complain("'" + printable(line) + "' has no ], must be [section]");
    return {};
  }
  if (close + 1 != line.size()) {
    complain("'" + printable(trimmed(line.substr(close + 1))) + "' after [section], must be in a line of its own");
  }
  std::string_view name = trimmed(line.substr(1, close - 1));
  if (!is_section(name)) {
    complain(unknown_section(name));
    name = nearest_section(name);  // its keys are judged as if they stood there
  }
  skip_section_ = name.empty();
  return "[" + std::string(name) + "]";
}

void Reader::close_line() {
  if (open_line_) complain("not a [section], a key = value, or a comment");
  open_line_ = false;
}

int Reader::take(std::string_view section, std::string_view key, std::string_view value) {
  if (key.empty()) return 0;
  open_line_ = false;
  if (skip_section_) return 1;
  if (!section.empty()) {
    values_.assign(here(), section, key, value);
    return 1;
  }
  const std::string home = sections_with(key);
  complain("'" + printable(key) + "' stands before the first [section]" + (home.empty() ? "" : ", must be in " + home));
  return 1;
}

void apply(const std::string& option, Assignments& values) {
  const Place place{"--set " + printable(option)};
  const size_t equals = option.find('=');
  const std::string_view name = trimmed(std::string_view(option).substr(0, equals));
  const size_t dot = name.rfind('.');
  if (equals == option.npos || dot == name.npos) {
    return values.complain(place, "must be SECTION.KEY=VALUE, such as \"image source.ndisp=64\"");
  }
  std::string section = section_name(trimmed(name.substr(0, dot)));
  if (!is_section(section)) {
    values.complain(place, unknown_section(section));
    section = nearest_section(section);
  }
  if (section.empty()) return;
  values.assign(place, section, trimmed(name.substr(dot + 1)), trimmed(std::string_view(option).substr(equals + 1)));
}

}  // namespace

ConfigReading read_config(const fs::path& path, std::span<const std::string> sets, Config& config) {
  std::error_code ignored;  // without a working folder relative paths stay as they are
  Assignments values(fs::absolute(path, ignored).parent_path());
  if (!path.empty()) Reader(values, path).read();
  values.options_begin(fs::current_path(ignored));
  for (const std::string& option : sets) apply(option, values);
  return values.finish(path.string(), config);
}

}  // namespace vdisp
