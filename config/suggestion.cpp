// suggestion.cpp: what was probably meant by a name that is not in the table.
// SPDX-License-Identifier: Apache-2.0
#include "config/suggestion.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "config/parameters.h"
#include "config/quoting.h"

namespace vdisp {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }

constexpr size_t any_distance = 1000;

// A third of the letters may be wrong: more is another word.
size_t tolerance(std::string_view name, size_t least) { return std::max(least, std::min<size_t>(name.size(), 30) / 3); }

/// `section` empty: anywhere. Null where none is within `most`.
const Parameter* nearest_key(std::string_view section, std::string_view key, size_t most) {
  const Parameter* best = nullptr;
  size_t least = most + 1;
  for (const Parameter& row : parameters()) {
    if (!section.empty() && row.section != section) continue;
    const size_t distance = edit_distance(row.key, key);
    if (distance >= least) continue;
    least = distance;
    best = &row;
  }
  return best;
}

}  // namespace

size_t edit_distance(std::string_view a, std::string_view b) {
  constexpr size_t long_enough = 64;  // no name is longer; a line of rubbish may be
  a = a.substr(0, long_enough);
  b = b.substr(0, long_enough);
  std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  const auto same = [&](size_t i, size_t j) { return lower(a[i]) == lower(b[j]); };
  for (size_t i = 0; i < a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j] + (same(i, j) ? 0 : 1), last[j + 1] + 1, row[j] + 1});
      if (i > 0 && j > 0 && same(i, j - 1) && same(i - 1, j)) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
    }
  }
  return row[b.size()];
}

std::string_view nearest_section(std::string_view name) {
  std::string_view best;
  size_t least = tolerance(name, 1) + 1;
  for (const Section& section : sections()) {
    const size_t distance = edit_distance(section.name, name);
    if (distance >= least) continue;
    least = distance;
    best = section.name;
  }
  return best;
}

std::string unknown_section(std::string_view name) {
  const std::string found = "no section [" + printable(name) + "]";
  const std::string_view near = nearest_section(name);
  if (!near.empty()) return found + ", nearest is [" + std::string(near) + "]";
  std::string known;
  for (const Section& section : sections()) known += (known.empty() ? "[" : ", [") + std::string(section.name) + "]";
  return found + ", there are " + known;
}

std::string unknown_key(std::string_view section, std::string_view key) {
  const std::string found = "no parameter '" + printable(key) + "' in [" + std::string(section) + "]";
  const std::string home = sections_with(key);
  if (!home.empty()) return found + ", it belongs to " + home;
  const size_t most = tolerance(key, 2);
  if (const Parameter* near = nearest_key(section, key, most)) return found + ", nearest is '" + std::string(near->key) + "'";
  if (const Parameter* near = nearest_key({}, key, most)) {
    return found + ", nearest is '" + std::string(near->key) + "' in [" + std::string(near->section) + "]";
  }
  std::string known;
  for (const Parameter& row : parameters())
    if (row.section == section) known += (known.empty() ? "" : ", ") + std::string(row.key);
  return found + ", nearest is '" + std::string(nearest_key(section, key, any_distance)->key) + "', there are " + known;
}

std::string sections_with(std::string_view key) {
  std::string text;
  for (const Parameter& row : parameters())
    if (row.key == key) text += (text.empty() ? "[" : " or [") + std::string(row.section) + "]";
  return text;
}

}  // namespace vdisp
