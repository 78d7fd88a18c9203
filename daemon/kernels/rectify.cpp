// rectify.cpp: how the table of a rectification is packed, and its plain use.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/rectify.h"

#include <algorithm>

namespace vdisp::kernels {
namespace {

struct Span {
  int least, most;
  int length() const { return most - least; }
  /// With one more on the far side, as interpolation needs.
  bool inside(int size) const { return least >= 0 && most + 1 < size; }
};

template <class Sources>
Span span(const Sources& sources, int RectifyTable::Source::*number) {
  Span all{sources[0].*number, sources[0].*number};
  for (const auto& s : sources) all = {std::min(all.least, s.*number), std::max(all.most, s.*number)};
  return all;
}

constexpr uint8_t elsewhere = 0x80;

}  // namespace

RectifyTable::RectifyTable(Plane<const int16_t> whole, Plane<const uint16_t> part, View8 raw)
    : blocks_((part.width + block - 1) / block),
      lines_((part.width + line - 1) / line),
      raw_stride_(raw.stride),
      parts_(static_cast<size_t>(2 * lines_ * part.height + 1)),  // one more: vectors may begin at the last block
      rows_(static_cast<size_t>(part.height), uint8_t{2}),
      places_(static_cast<size_t>(blocks_ * part.height)),
      patterns_(places_.size()) {
  Numbers numbers;
  std::vector<Sources> row(static_cast<size_t>(blocks_));
  for (int y = 0; y < part.height; ++y) {
    uint8_t *part_x = parts_[static_cast<size_t>(2 * y * lines_)].bytes, *part_y = part_x + lines_ * line;
    for (int x = 0; x < blocks_ * block; ++x) {
      const int from = std::min(x, part.width - 1), parts = part.row(y)[from] & 1023;
      part_x[x] = static_cast<uint8_t>(parts & 31);
      part_y[x] = static_cast<uint8_t>(parts >> 5 << 2);
      row[static_cast<size_t>(x / block)][x % block] = {whole.row(y)[2 * from], whole.row(y)[2 * from + 1], parts & 31, parts >> 5};
    }
    // One height for the whole row: to change between two costs more than higher windows do.
    uint8_t& rows = rows_[static_cast<size_t>(y)];
    for (const Sources& sources : row) {
      const Span needed = span(sources, &Source::row);
      if (needed.length() >= rows && needed.length() < most_rows && needed.inside(raw.height)) rows = most_rows;
    }
    for (size_t b = 0; b < row.size(); ++b) add_block(row[b], raw, rows, static_cast<size_t>(y * blocks_) + b, numbers);
  }
}

void RectifyTable::add_block(const Sources& sources, View8 raw, int rows, size_t b, Numbers& numbers) {
  const auto outside = [&](const Source& s) { return s.column < -1 || s.column >= raw.width || s.row < -1 || s.row >= raw.height; };
  places_[b] = ~static_cast<int32_t>(special_.size());
  if (std::all_of(sources.begin(), sources.end(), outside)) {
    places_[b] = nowhere;
  } else if (!add_window(sources, raw, rows, b, numbers)) {
    special_.push_back({Kind::scattered, 0, 0, static_cast<uint32_t>(scattered_.size())});
    scattered_.push_back(sources);
  }
}

bool RectifyTable::add_window(const Sources& sources, View8 raw, int rows, size_t b, Numbers& numbers) {
  const Span x = span(sources, &Source::column), y = span(sources, &Source::row);
  if (x.length() > window - 2 || y.length() >= most_rows || raw.width < window) return false;
  const bool inside = x.inside(raw.width) && y.inside(raw.height) && y.length() < rows && rows < raw.height;
  // The window is moved back into the image.
  const int column = inside ? std::min(x.least, raw.width - window) : x.least;
  const int row = inside ? std::min(y.least, raw.height - rows - 1) : y.least;
  if (!add_pattern(sources, column, row, patterns_[b], numbers)) return false;
  if (inside) {
    places_[b] = static_cast<int32_t>(row * raw.stride + column);
  } else {
    special_.push_back({Kind::border, static_cast<int16_t>(column), static_cast<int16_t>(row), 0});
  }
  return true;
}

bool RectifyTable::add_pattern(const Sources& sources, int column, int row, uint16_t& to, Numbers& numbers) {
  Pattern pattern;
  uint64_t content = 0;
  for (size_t i = 0; i < block; ++i) {
    const int x = sources[i].column - column, y = sources[i].row - row;
    for (int of = 0; of < most_rows; ++of) {
      const int flag = of == y ? 0 : elsewhere;
      pattern.in_row[of][2 * i] = static_cast<uint8_t>(x | flag);
      pattern.in_row[of][2 * i + 1] = static_cast<uint8_t>((x + 1) | flag);
    }
    content = content << 8 | static_cast<uint8_t>(y << 4 | x);
  }
  const auto [known, is_new] = numbers.try_emplace(content, static_cast<uint16_t>(pattern_.size()));
  if (is_new && pattern_.size() == most_patterns) {
    numbers.erase(known);
    return false;
  }
  if (is_new) pattern_.push_back(pattern);
  to = known->second;
  return true;
}

RectifyTable::Source RectifyTable::source(int x, int y) const {
  const int b = x / block, i = x % block * 2, part_x = parts_x(y)[x], part_y = parts_y(y)[x] >> 2;
  const int32_t place = places(y)[b];
  if (place == nowhere) return {-2, -2, 0, 0};
  if (place < 0 && special(place).kind == Kind::scattered) return scattered(special(place))[static_cast<size_t>(i) / 2];
  const Pattern& pattern = pattern_[patterns(y)[b]];
  int row = 0;
  while (pattern.in_row[row][i] & elsewhere) ++row;
  const int column = pattern.in_row[row][i];
  if (place < 0) return {special(place).column + column, special(place).row + row, part_x, part_y};
  return {static_cast<int>(place % raw_stride_) + column, static_cast<int>(place / raw_stride_) + row, part_x, part_y};
}

size_t RectifyTable::count(Kind kind) const {
  const auto empty = static_cast<size_t>(std::count(places_.begin(), places_.end(), nowhere));
  if (kind == Kind::empty) return empty;
  if (kind == Kind::inside) return places_.size() - special_.size() - empty;
  return static_cast<size_t>(std::count_if(special_.begin(), special_.end(), [&](const Special& s) { return s.kind == kind; }));
}

namespace plain {

uint8_t rectified(View8 in, const RectifyTable::Source& from) {
  const auto inside = [&](int column, int row) { return column >= 0 && column < in.width && row >= 0 && row < in.height; };
  const auto pixel = [&](int column, int row) -> int { return inside(column, row) ? in.row(row)[column] : 0; };
  const auto formula = [&](int a, int b, int c, int d) {
    const int top = (32 - from.part_x) * a + from.part_x * b, bottom = (32 - from.part_x) * c + from.part_x * d;
    return static_cast<uint8_t>((top + (((bottom - top) * from.part_y + 16) >> 5) + 16) >> 5);
  };
  const int x = from.column, y = from.row;
  if (inside(x, y) && inside(x + 1, y + 1)) {
    const uint8_t *above = in.row(y) + x, *below = in.row(y + 1) + x;
    return formula(above[0], above[1], below[0], below[1]);
  }
  return formula(pixel(x, y), pixel(x + 1, y), pixel(x, y + 1), pixel(x + 1, y + 1));
}

void rectify(const RectifyTable& table, View8 in, int first, int last, Plane<uint8_t> out) {
  for (int y = first; y < last; ++y)
    for (int x = 0; x < out.width; ++x) out.row(y)[x] = rectified(in, table.source(x, y));
}

}  // namespace plain

}  // namespace vdisp::kernels
