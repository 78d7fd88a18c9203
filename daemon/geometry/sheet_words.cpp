// sheet_words.cpp: takes YAML and XML apart into words and the names they stand under, as much of both as calibrations use.
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <sstream>

#include "daemon/geometry/sheet.h"

namespace vdisp::calibration {
namespace {

constexpr size_t deepest = 16;
constexpr const char* blanks = " \t\r\n";

std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(blanks);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string unquoted(const std::string& text) {
  const bool quoted = text.size() >= 2 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0];
  return quoted ? text.substr(1, text.size() - 2) : text;
}

/// Without its comment: from a # at the start or behind a blank, outside quotes.
std::string without_comment(const std::string& line) {
  char quote = 0;
  for (size_t i = 0; i < line.size(); ++i) {
    if (quote)
      quote = line[i] == quote ? 0 : quote;
    else if (line[i] == '"' || line[i] == '\'')
      quote = line[i];
    else if (line[i] == '#' && (i == 0 || std::strchr(blanks, line[i - 1])))
      return line.substr(0, i);
  }
  return line;
}

class Yaml {
 public:
  Yaml(const std::string& file, const std::string& content) : file_(file) {
    std::istringstream in(content);
    for (std::string line; std::getline(in, line);) {
      ++number_;
      read(without_comment(line));
    }
    if (open_ > 0) refuse(file_, "is damaged: it ends within a list in brackets");
  }
  Words words() { return std::move(words_); }

 private:
  [[noreturn]] void refuse_line(const std::string& what) const { refuse(file_ + ":" + std::to_string(number_), "is damaged: " + what); }

  void read(const std::string& line) {
    const std::string content = trimmed(line);
    if (content.empty()) return;
    if (open_ > 0) return read_list(content);
    if (content[0] == '%' || content == "---" || content == "...") return;
    const size_t indent = line.find_first_not_of(' ');
    if (line[indent] == '\t') refuse_line("a tab before '" + content.substr(0, 20) + "', needed are blanks");
    if (content == "-" || content.starts_with("- ")) return read_item(trimmed(content.substr(1)));
    const size_t colon = content.find(':');
    const bool named = colon != std::string::npos && colon > 0 && (colon + 1 == content.size() || std::strchr(blanks, content[colon + 1]));
    if (!named) {
      if (!places_.empty() && indent > places_.back().indent) return;  // a text goes on
      refuse_line("'" + content.substr(0, 20) + "', needed is 'name: value'");
    }
    read_name(indent, unquoted(trimmed(content.substr(0, colon))), trimmed(content.substr(colon + 1)));
  }

  void read_name(size_t indent, const std::string& name, std::string value) {
    while (!places_.empty() && places_.back().indent >= indent) places_.pop_back();
    if (places_.size() >= deepest) refuse_line("names within names, deeper than any calibration");
    places_.push_back({indent, places_.empty() ? name : places_.back().path + "/" + name});
    if (value.starts_with('!')) value = value.find(' ') == std::string::npos ? "" : trimmed(value.substr(value.find(' ')));  // a tag
    if (!words_.try_emplace(here()).second) refuse_line("'" + name + "' for the second time");
    if (value.starts_with('['))
      read_list(value);
    else if (!value.empty())
      words_[here()].push_back(unquoted(value));
  }

  void read_item(const std::string& item) {
    if (places_.empty()) refuse_line("an item of a list without a name");
    if (!item.empty()) words_[here()].push_back(unquoted(item));
  }

  void read_list(const std::string& content) {
    std::string word;
    const auto end_word = [&] {
      if (!word.empty()) words_[here()].push_back(unquoted(word));
      word.clear();
    };
    for (char c : content) {
      if (c == '[') ++open_;
      if (c == ']' && --open_ < 0) refuse_line("a bracket is closed that was not opened");
      if (c == '[' || c == ']' || c == ',' || std::strchr(blanks, c))
        end_word();
      else if (open_ == 0)
        refuse_line("something follows a list");
      else
        word += c;
    }
    end_word();
  }

  const std::string& here() const { return places_.back().path; }

  struct Place {
    size_t indent;
    std::string path;
  };
  const std::string& file_;
  int number_ = 0, open_ = 0;
  std::vector<Place> places_;
  Words words_;
};

}  // namespace

Words words_of_yaml(const std::string& file, const std::string& content) { return Yaml(file, content).words(); }

/// Everything stands in one element, opencv_storage, which is no part of the names.
Words words_of_xml(const std::string& file, const std::string& content) {
  Words words;
  std::vector<std::string> names;
  const auto path = [&names] {
    std::string all;
    for (size_t i = 1; i < names.size(); ++i) all += (all.empty() ? "" : "/") + names[i];
    return all;
  };
  for (size_t at = 0; at < content.size();) {
    const size_t open = std::min(content.find('<', at), content.size());
    std::istringstream text(content.substr(at, open - at));
    for (std::string word; text >> word;) words[path()].push_back(unquoted(word));
    if (open == content.size()) break;
    const bool comment = content.compare(open, 4, "<!--") == 0;
    const size_t close = content.find(comment ? "-->" : ">", open);
    if (close == std::string::npos) refuse(file, "is damaged: it ends within a tag");
    at = close + (comment ? 3 : 1);
    if (comment || content[open + 1] == '?' || content[open + 1] == '!') continue;
    const bool ends = content[open + 1] == '/';
    const size_t begin = open + (ends ? 2 : 1);
    const std::string name = content.substr(begin, std::min(content.find_first_of(" \t\r\n/>", begin), close) - begin);
    if (ends && (names.empty() || names.back() != name)) refuse(file, "is damaged: </" + name.substr(0, 20) + "> closes what is not open");
    if (!ends && names.size() >= deepest) refuse(file, "is damaged: elements within elements, deeper than any calibration");
    if (ends)
      names.pop_back();
    else if (content[close - 1] != '/')
      names.push_back(name);
    if (!ends && names.size() > 1 && content[close - 1] != '/' && !words.try_emplace(path()).second)
      refuse(file, "is damaged: <" + name.substr(0, 20) + "> for the second time");
  }
  if (!names.empty()) refuse(file, "is damaged: it ends within <" + names.back().substr(0, 20) + ">");
  return words;
}

}  // namespace vdisp::calibration
