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

// A third of the letters may be wrong: more is another word.
size_t tolerance(std::string_view name) { return std::max<size_t>(1, std::min<size_t>(name.size(), 30) / 3); }

/// `section` empty: anywhere.
const Parameter* nearest_key(std::string_view section, std::string_view key) {
  const Parameter* best = nullptr;
  size_t least = tolerance(key) + 1;
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
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t change = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

std::string_view nearest_section(std::string_view name) {
  std::string_view best;
  size_t least = tolerance(name) + 1;
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
  if (const Parameter* near = nearest_key(section, key)) return found + ", nearest is '" + std::string(near->key) + "'";
  if (const Parameter* near = nearest_key({}, key)) {
    return found + ", nearest is '" + std::string(near->key) + "' in [" + std::string(near->section) + "]";
  }
  std::string known;
  for (const Parameter& row : parameters())
    if (row.section == section) known += (known.empty() ? "" : ", ") + std::string(row.key);
  return found + ", there are " + known;
}

std::string sections_with(std::string_view key) {
  std::string text;
  for (const Parameter& row : parameters())
    if (row.key == key) text += (text.empty() ? "[" : " or [") + std::string(row.section) + "]";
  return text;
}

}  // namespace vdisp
