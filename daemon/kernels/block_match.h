// block_match.h: contracts: block matching row by row: for each pixel the disparity that costs least, and what filters ask of its rivals.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Parts of costs are given in 1/65536, rounded up, and are less than 1: p percent of c is c * percent_factor(p) >> 16.
constexpr int percent_factor(int percent) { return (65536 * percent + 99) / 100; }

/// What a pixel of the left view costs against one of the right view.
enum class Cost {
  differences,  ///< |l - r|, at most `cap`: truncated absolute differences
  hamming,      ///< the bits that differ, of `left` and `right`
  hamming_two,  ///< the same of two planes each
};

/// Bytes behind each row of a mirrored plane that are read, whatever they hold.
inline constexpr int mirrored_margin = 64;

/// One search. The planes hold pre-filtered pixels, at most 127, or census codes. Those of the right view are mirrored: the pixel of column
/// x stands at width - 1 - x, so that the candidates of a pixel lie side by side in memory.
struct BlockSearch {
  Cost cost = Cost::differences;
  int cap = 23;           ///< most that a pixel may cost; window * cap <= 255
  int window = 11;        ///< odd, 5 .. 21
  int disparities = 48;   ///< multiple of 16, 16 .. 256
  int min_disparity = 0;  ///< px
  int unique = 0;         ///< part of its cost by which a match must beat its rivals (percent_factor); 0: not asked
  int left_right = 0;     ///< part by which the right view must match better elsewhere to refuse a match
  int home = -1;          ///< index whose cost is wanted besides, 1 .. disparities - 2; -1: none
  View8 left, right;
  View8 left_more, right_more;  ///< hamming_two

  /// Columns [first, last) have window and whole search inside the image; where last <= first there are none.
  int first_column() const { return window / 2 + (min_disparity + disparities > 1 ? min_disparity + disparities - 1 : 0); }
  int last_column() const { return left.width - window / 2 + (min_disparity < 0 ? min_disparity : 0); }
};

/// Why a candidate is not to be trusted; bits.
inline constexpr uint16_t candidate_not_unique = 1, candidate_left_right = 2;

/// One row, an element a pixel, valid for columns [first_column, last_column) of the search. Up to `row_margin` elements behind the
/// last column are written, whatever they hold.
inline constexpr int row_margin = 32;
struct Candidates {
  uint16_t* index;    ///< the disparity that costs least is min_disparity + index; of equals the smallest
  uint16_t* cost;     ///< its cost, the sum over the window
  uint16_t* before;   ///< cost of index - 1, of index + 1 where the search begins
  uint16_t* after;    ///< cost of index + 1, of index - 1 where the search ends
  uint16_t* refused;  ///< candidate_ bits
  uint16_t* home;     ///< the least cost of the search's home and the two beside it; null where none is wanted
};

/// Work space of one band of rows for searches of up to this size.
class BlockScratch {
 public:
  BlockScratch() = default;
  BlockScratch(int width, int disparities);

  uint8_t* columns() { return memory_[0].bytes; }  ///< a sum over the window's rows for each column and disparity
  int16_t* costs() { return words(columns_lines_); }
  int16_t* right_best() { return words(columns_lines_ + cost_lines_); }
  int16_t* sums() { return words(columns_lines_ + cost_lines_ + right_lines_); }
  int16_t* row(size_t i) { return words(columns_lines_ + cost_lines_ + right_lines_ + sum_lines_ + i * row_lines_); }  ///< i < 4

 private:
  struct alignas(64) Line {
    uint8_t bytes[64];
  };
  int16_t* words(size_t line) { return reinterpret_cast<int16_t*>(memory_[line].bytes); }
  size_t columns_lines_ = 0, cost_lines_ = 0, right_lines_ = 0, sum_lines_ = 0, row_lines_ = 0;
  std::vector<Line> memory_;
};

/// Candidates of row `row`, which has the window inside the image: window / 2 <= row < height - window / 2. With `fresh` the row is the
/// first of a band; without it the last call with this scratch was for row - 1 of the same search.
///
/// not unique: a disparity more than 1 px away costs at most cost and the part `unique` of it. left/right: the matched pixel
/// of the right view has, among all pixels of the left one, a match that is cheaper even with the part `left_right` of its
/// cost added than this one and than those that lead to the same right pixel from 1 px beside it.
using MatchRow = void(const BlockSearch& search, int row, bool fresh, BlockScratch& scratch, const Candidates& out);

namespace plain {
MatchRow match_row;
}

}  // namespace vdisp::kernels
