// rectify.h: contracts: a raw view to its rectified view, by a table that says where each pixel comes from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Where each pixel of a rectified image lies in the raw one, in whole pixels and 1/32: 2.75 bytes a pixel. Made once, while building.
///
/// Maps of lenses are smooth: eight neighbours come from few rows and a short span of columns. So a row is cut into blocks of eight
/// pixels, and a block is the place of its window in the raw image, 16 columns and two or four rows, and a pattern: where in the window its
/// pixels lie. There are a few hundred patterns in a map. A block that fits no window keeps eight places instead, and is slow.
class RectifyTable {
 public:
  static constexpr int block = 8, window = 16, most_rows = 4, most_patterns = 1 << 16;
  /// inside = the window and the row below it are in the raw image; border = not all of it; empty = the pixels are all outside;
  /// scattered = they fit no window, or there are too many patterns.
  enum class Kind : uint8_t { inside, border, empty, scattered };
  struct Special {
    Kind kind;            ///< border or scattered
    int16_t column, row;  ///< border: of the window's first pixel
    uint32_t scattered;   ///< scattered: which eight places
  };
  static constexpr int32_t nowhere = INT32_MIN;
  /// For each row of the window, for each pixel two bytes: the columns of its two upper sources, with 0x80 if they lie in
  /// another row.
  struct alignas(64) Pattern {
    uint8_t in_row[most_rows][window];
  };
  /// The four pixels at (column, row), to the right, below, and both; parts in 1/32 px.
  struct Source {
    int column, row, part_x, part_y;
  };
  using Sources = std::array<Source, block>;

  RectifyTable() = default;
  /// `whole`: column and row, two numbers a pixel, so twice as wide as `part`; `part`: 32 * vertical + horizontal (the maps that
  /// OpenCV calls CV_16SC2). Any numbers: what lies outside the raw image is 0. Of `raw` only size and stride count.
  RectifyTable(Plane<const int16_t> whole, Plane<const uint16_t> part, View8 raw);

  bool empty() const { return places_.empty(); }
  Source source(int x, int y) const;
  /// How many of all blocks are of a kind.
  size_t count(Kind kind) const;

  /// Rows of the inside windows of row y, 2 or most_rows.
  int rows(int y) const { return rows_[static_cast<size_t>(y)]; }
  /// One number a block of row y: offset of its window in the raw image; `nowhere`: empty; else negative: ~place is the number of a
  /// Special.
  const int32_t* places(int y) const { return places_.data() + y * blocks_; }
  /// The number of each block's pattern.
  const uint16_t* patterns(int y) const { return patterns_.data() + y * blocks_; }
  const Pattern* pattern() const { return pattern_.data(); }
  const Special& special(int32_t place) const { return special_[static_cast<size_t>(~place)]; }
  const Sources& scattered(const Special& special) const { return scattered_[special.scattered]; }
  /// One byte a pixel of row y, in whole vectors: part_x, and 4 * part_y.
  const uint8_t* parts_x(int y) const { return parts_[static_cast<size_t>(2 * y * lines_)].bytes; }
  const uint8_t* parts_y(int y) const { return parts_[static_cast<size_t>((2 * y + 1) * lines_)].bytes; }

 private:
  static constexpr int line = 64;
  struct alignas(line) Line {
    uint8_t bytes[line];
  };
  using Numbers = std::unordered_map<uint64_t, uint16_t>;  // patterns by their content
  void add_block(const Sources& sources, View8 raw, int rows, size_t b, Numbers& numbers);
  bool add_window(const Sources& sources, View8 raw, int rows, size_t b, Numbers& numbers);
  bool add_pattern(const Sources& sources, int column, int row, uint16_t& to, Numbers& numbers);

  ptrdiff_t blocks_ = 0, lines_ = 0, raw_stride_ = 0;
  std::vector<Line> parts_;
  std::vector<uint8_t> rows_;
  std::vector<int32_t> places_;
  std::vector<uint16_t> patterns_;
  std::vector<Pattern> pattern_;
  std::vector<Special> special_;
  std::vector<Sources> scattered_;
};

/// Rows [first, last) of the rectified image: of four pixels a b above c d, raw pixels or 0 where outside, with the parts x and y
///   top = (32 - x) a + x b, bottom = (32 - x) c + x d, out = (top + ((bottom - top) y + 16 >> 5) + 16) >> 5
/// which is bilinear interpolation to 1/32 px, at most one level from cv::remap. `in` has the size and stride that the table was made
/// for, `out` the size of the map; they are not the same memory. Other rows are not touched.
using Rectify = void(const RectifyTable& table, View8 in, int first, int last, Plane<uint8_t> out);

namespace plain {
Rectify rectify;
/// One pixel.
uint8_t rectified(View8 in, const RectifyTable::Source& from);
}  // namespace plain

}  // namespace vdisp::kernels
