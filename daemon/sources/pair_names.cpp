// pair_names.cpp: lists the image files of a recording and pairs them.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/pair_names.h"

#include <glob.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <system_error>

#include "daemon/sources/natural_order.h"
#include "daemon/sources/source.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;
constexpr const char* wildcards = "*?[";

/// What is there instead, for people who mistyped a path.
std::string what_is_there(const fs::path& folder) {
  std::error_code error;
  const fs::path place = folder.empty() ? fs::path(".") : folder;
  if (!fs::exists(place, error)) return "there is no folder " + place.string();
  if (!fs::is_directory(place, error)) return place.string() + " is no folder";
  std::set<std::string, NaturalLess> names;
  for (fs::directory_iterator i(place, error), end; !error && i != end; i.increment(error)) names.insert(i->path().filename().string());
  if (error) return "the folder " + place.string() + " cannot be read: " + error.message();
  if (names.empty()) return "the folder " + place.string() + " is empty";
  return "the folder " + place.string() + " holds " + std::to_string(names.size()) + (names.size() == 1 ? " name: " : " names, first ") +
         *names.begin();
}

/// How much of a name is leading folders that there are, by exactly this name: no wildcards and no numbers stand in it.
size_t literal_length(const std::string& name) {
  size_t length = 0;
  for (size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    std::error_code error;
    if (!fs::is_directory(name.substr(0, slash + 1), error)) break;
    length = slash + 1;
  }
  return length;
}

/// Where the next % stands that is not half of a %%, which is a plain one.
size_t find_conversion(const std::string& name, size_t from) {
  size_t at = name.find('%', from);
  while (at != std::string::npos && name.compare(at, 2, "%%") == 0) at = name.find('%', at + 2);
  return at;
}

std::string plain(std::string text) {
  for (size_t at = text.find("%%"); at != std::string::npos; at = text.find("%%", at + 1)) text.erase(at, 1);
  return text;
}

/// A name with one number in it, in any part of the path.
class Pattern {
 public:
  Pattern(const std::string& key, const std::string& text) : key_(key), text_(text) {
    const size_t literal = literal_length(text);
    size_t at = find_conversion(text, literal);
    if (at == std::string::npos) refuse();
    before_ = text.substr(0, literal) + plain(text.substr(literal, at - literal));
    ++at;
    if (at < text.size() && text[at] == '0') zero_ = true, ++at;
    const size_t digits = at;
    while (at < text.size() && is_digit(text[at])) ++at;
    if (at - digits > 2) refuse();
    if (at > digits) width_ = static_cast<size_t>(std::stoi(text.substr(digits, at - digits)));
    if (at >= text.size() || text[at] != 'd') refuse();
    if (find_conversion(text, at + 1) != std::string::npos) refuse();
    after_ = plain(text.substr(at + 1));
  }

  std::string name(int64_t number) const { return before_ + digits(number) + after_; }

  /// Numbers of the files there are.
  std::set<int64_t> numbers() const {
    const size_t slash = before_.rfind('/');
    const fs::path folder = slash == std::string::npos ? fs::path(".") : fs::path(before_.substr(0, slash + 1));
    const std::string head = slash == std::string::npos ? before_ : before_.substr(slash + 1);
    const std::string tail = after_.substr(0, after_.find('/')), rest = after_.substr(tail.size());
    std::set<int64_t> found;
    std::error_code error;
    for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
      const std::string entry = i->path().filename().string();
      if (entry.size() < head.size() + tail.size() || !entry.starts_with(head) || !entry.ends_with(tail)) continue;
      const int64_t number = parse(entry.substr(head.size(), entry.size() - head.size() - tail.size()));
      std::error_code ignored;
      if (number >= 0 && (rest.empty() || fs::exists(i->path().string() + rest, ignored))) found.insert(number);
    }
    if (found.empty()) throw SourceError(66, "[image source] " + key_ + " = " + text_ + ": no such image; " + what_is_there(folder));
    return found;
  }

 private:
  [[noreturn]] void refuse() const {
    throw SourceError(
        78, "[image source] " + key_ + " = " + text_ + ": not a pattern; needed is one number, %d or like %06d; a plain % is written %%");
  }
  std::string digits(int64_t number) const {
    std::string result = std::to_string(number);
    if (result.size() < width_) result.insert(0, width_ - result.size(), zero_ ? '0' : ' ');
    return result;
  }
  /// -1 unless it is a number as this pattern writes it.
  int64_t parse(const std::string& written) const {
    const size_t begin = std::min(written.find_first_not_of(' '), written.size());
    int64_t number = -1;
    const auto [end, error] = std::from_chars(written.data() + begin, written.data() + written.size(), number);
    return error == std::errc() && number >= 0 && digits(number) == written ? number : -1;
  }

  std::string key_, text_, before_, after_;
  bool zero_ = false;
  size_t width_ = 0;
};

std::vector<PairName> list_patterns(const std::string& left, const std::string& right) {
  const Pattern a("left", left), b("right", right);
  std::set<int64_t> numbers = a.numbers();
  numbers.merge(b.numbers());
  const int64_t first = *numbers.begin(), last = *numbers.rbegin();
  if ((last - first) / 10 > static_cast<int64_t>(numbers.size()) + 100)
    throw SourceError(78, "[image source] left = " + left + ": numbers run from " + std::to_string(first) + " to " + std::to_string(last) +
                              " but only " + std::to_string(numbers.size()) +
                              " are there; needed is a glob (*) for names that are not counted");
  std::vector<PairName> pairs;
  for (int64_t number = first; number <= last; ++number) pairs.push_back({a.name(number), b.name(number)});
  return pairs;
}

/// Files that match, by what the wildcards stand for.
struct GlobNames {
  std::string text, before, after;
  std::map<std::string, std::string, NaturalLess> files;
  std::string name(const std::string& stem) const { return before + stem + after; }
};

GlobNames list_glob(const std::string& key, const std::string& text) {
  const size_t literal = literal_length(text);
  const std::string head = text.substr(0, literal), rest = plain(text.substr(literal));
  const size_t first = rest.find_first_of(wildcards), last = rest.find_last_of("*?]");
  GlobNames names{text, head + rest.substr(0, first), last == std::string::npos ? "" : rest.substr(last + 1), {}};
  std::string escaped;
  for (const char c : head) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  glob_t found{};
  glob((escaped + rest).c_str(), GLOB_NOSORT, nullptr, &found);
  for (size_t i = 0; i < found.gl_pathc; ++i) {
    const std::string path = found.gl_pathv[i];
    std::error_code error;
    if (!fs::is_regular_file(path, error) || path.size() < names.before.size() + names.after.size()) continue;
    names.files[path.substr(names.before.size(), path.size() - names.before.size() - names.after.size())] = path;
  }
  globfree(&found);
  if (names.files.empty())
    throw SourceError(66, "[image source] " + key + " = " + text + ": no such image; " +
                              what_is_there(fs::path(names.before.substr(0, names.before.rfind('/') + 1))));
  return names;
}

std::vector<PairName> list_globs(const std::string& left, const std::string& right) {
  const GlobNames a = list_glob("left", left), b = list_glob("right", right);
  std::set<std::string, NaturalLess> stems;
  size_t common = 0;
  for (const auto& [stem, path] : a.files) stems.insert(stem), common += b.files.count(stem);
  for (const auto& [stem, path] : b.files) stems.insert(stem);
  std::vector<PairName> pairs;
  if (2 * common >= std::min(a.files.size(), b.files.size())) {
    for (const std::string& stem : stems) {
      const auto l = a.files.find(stem), r = b.files.find(stem);
      pairs.push_back({l == a.files.end() ? a.name(stem) : l->second, r == b.files.end() ? b.name(stem) : r->second});
    }
    return pairs;
  }
  if (a.files.size() != b.files.size())
    throw SourceError(78, "[image source] left = " + left + " matches " + std::to_string(a.files.size()) + " images, right = " + right +
                              " " + std::to_string(b.files.size()) +
                              ", and their names do not agree; needed are as many or the same names");
  for (auto l = a.files.begin(), r = b.files.begin(); l != a.files.end(); ++l, ++r) pairs.push_back({l->second, r->second});
  return pairs;
}

/// -1 unless the file's name holds a number of 16 digits or more.
int64_t recorded_ns(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  for (auto begin = stem.begin(); begin != stem.end();) {
    begin = std::find_if(begin, stem.end(), is_digit);
    const auto end = std::find_if_not(begin, stem.end(), is_digit);
    int64_t number = -1;
    if (end - begin >= 16 && std::from_chars(&*begin, &*begin + (end - begin), number).ec == std::errc()) return number;
    begin = end;
  }
  return -1;
}

}  // namespace

NameForm form_of(const std::string& name) {
  std::error_code error;
  if (fs::exists(name, error)) return NameForm::literal;
  const size_t literal = literal_length(name);
  if (find_conversion(name, literal) != std::string::npos) return NameForm::pattern;
  return name.find_first_of(wildcards, literal) != std::string::npos ? NameForm::glob : NameForm::literal;
}

std::string describe(NameForm form) {
  switch (form) {
    case NameForm::literal: return "one file";
    case NameForm::pattern: return "a printf pattern";
    case NameForm::glob: return "a glob";
  }
  return {};
}

std::vector<PairName> list_pairs(const std::string& left, const std::string& right) {
  const NameForm form = form_of(left);
  std::vector<PairName> pairs;
  if (form == NameForm::pattern)
    pairs = list_patterns(left, right);
  else if (form == NameForm::glob)
    pairs = list_globs(left, right);
  else
    pairs = {{left, right}};
  int64_t last = -1;
  for (const PairName& pair : pairs) {
    const int64_t time = recorded_ns(pair.left);
    if (time <= last) return pairs;
    last = time;
  }
  for (PairName& pair : pairs) pair.recorded_ns = recorded_ns(pair.left);
  return pairs;
}

}  // namespace vdisp
