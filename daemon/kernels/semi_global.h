// semi_global.h: contracts: semi-global matching on sparse census codes: costs, paths across, paths down and up, winners of a row.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

#include "daemon/kernels/block_match.h"

namespace vdisp::kernels {

/// Census codes of 16 bits in two planes of 8: bit i says that the pixel at pair i's offset is darker than the one opposite, point-mirrored
/// about the centre. The pairs are spread over a window of 9 x 7. Pixels outside the image are those of its border.
/// Writes rows [first, last) of `low` and `high`, which have the size of `image`.
using SparseCensus = void(View8 image, int first, int last, Plane<uint8_t> low, Plane<uint8_t> high);

/// One search (Hirschmueller 2008). A pixel costs the bits in which its code differs from that of its match, summed over 3 x 3 pixels, / 4.
/// A path carries the least sum of costs and penalties on the way to a pixel; all sums end at 255.
struct SemiGlobal {
  int disparities = 64;   ///< multiple of 16, 16 .. 256
  int min_disparity = 0;  ///< px
  int paths = 3;          ///< 3: from the left, the right and above; 4: from below too; 8: the diagonals too, and every path counts half
  int small = 13;         ///< penalty of a step of 1 px
  int large = 120;        ///< of any other, less 2^slope for each grey level between the two pixels, but at least large_least
  int large_least = 27, slope = 2;
  int unique = 0;                                    ///< as in BlockSearch
  int most = 255;                                    ///< a sum of paths above it is no match, and counts as not unique
  int left_right = 0;                                ///< as in BlockSearch
  View8 image;                                       ///< the left view
  View8 left_low, left_high, right_low, right_high;  ///< codes

  /// Columns [first, last) have their whole search inside the right view; where last <= first there are none.
  int first_column() const { return std::max(min_disparity + disparities - 1, 0); }
  int last_column() const { return image.width + std::min(min_disparity, 0); }
  int columns() const { return std::max(last_column() - first_column(), 0); }
  /// Penalty of a jump between pixels that differ by `step` grey levels.
  int jump(int step) const { return std::max(large - (step << slope), large_least); }
};

/// Columns that the sub-pixel part is taken from: every third, up to six to either side. Five costs of at most 9 * 16 / 4 fit in a byte.
inline constexpr int sub_pixel_step = 3, sub_pixel_reach = 6;

/// Bytes behind the end of the code planes' rows that are read, whatever they hold.
inline constexpr int codes_margin = 64;

/// Costs and sums of paths, a byte each: of each group of rows_across rows blocks of 64 columns, of each block the rows, of each row the
/// disparities one after the other, of each disparity 64 columns. Column 0 is the search's first. Of an image so many rows are held, the
/// last ones written.
class SemiGlobalVolume {
 public:
  static constexpr int block = 64, rows_across = 16;
  static constexpr int beside = 8;                          ///< columns of other blocks that step 3 lays to either side of one's costs
  static constexpr int laid_out = block + 2 * beside + 16;  ///< bytes of such a row

  SemiGlobalVolume() = default;
  /// For searches in images `width` wide. `rows`: how many are held, a multiple of rows_across; with paths from below or diagonals they
  /// are all rows. `threads`: how many calls may run at a time. Throws std::bad_alloc.
  SemiGlobalVolume(int width, int rows, int disparities, int paths, int threads);

  uint8_t* costs(int row, int b) const { return costs_.get() + at(row, b); }
  uint8_t* sums(int row, int b) const { return sums_.get() + at(row, b); }
  int rows() const { return rows_; }
  size_t row_bytes() const { return static_cast<size_t>(block * disparities_ + 64); }  ///< from row to row of a group
  size_t block_bytes() const { return block * column_bytes(disparities_); }            ///< from block to block of a row
  /// Where the paths from above or below have got to; the kernels' own.
  uint8_t* states(int first_block) const { return states_.get() + static_cast<size_t>(first_block) * state_bytes_; }
  /// Work space of one call; the kernels' own.
  uint8_t* work(int thread) const { return work_.get() + static_cast<size_t>(thread) * work_bytes_; }
  size_t bytes() const { return bytes_; }

  /// Bytes of a column of rows_across rows. 64 more than needed: what is 4096 bytes apart would share the same few lines of a cache.
  static size_t column_bytes(int disparities) { return static_cast<size_t>(rows_across * disparities + 64); }

 private:
  static constexpr size_t page = 2 << 20;
  struct Free {
    void operator()(uint8_t* p) const { ::operator delete[](p, std::align_val_t{page}); }
  };
  using Memory = std::unique_ptr<uint8_t[], Free>;
  Memory reserve(size_t bytes);
  size_t at(int row, int b) const {
    const size_t group = static_cast<size_t>(row % rows_ / rows_across), row_bytes = static_cast<size_t>(block * disparities_ + 64);
    return (group * static_cast<size_t>(blocks_) + static_cast<size_t>(b)) * block_bytes() +
           static_cast<size_t>(row % rows_across) * row_bytes;
  }

  int disparities_ = 0, rows_ = 0, blocks_ = 0;
  size_t state_bytes_ = 0, work_bytes_ = 0, bytes_ = 0;
  Memory costs_, sums_, states_, work_;
};

/// Step 1: writes the costs of rows [row, row + rows_across) and, as their sums, the paths from the left and from the right. `row` is a
/// multiple of rows_across. Such groups do not depend on each other. All the group's costs and sums are written over, also behind the last
/// column.
using PathsAcross = void(const SemiGlobal& search, int row, const SemiGlobalVolume& volume, uint8_t* work);
/// Step 2, for rows that are through step 1: adds the paths from above, or with `up` those from below. Calls go on where the last one for
/// these blocks ended, from the first row to the last, or with `up` back from the last to the first. With 3 or 4 paths blocks
/// [first_block, last_block) do not depend on the others, and are always called alike; with 8 it is one call for all.
using PathsDown = void(const SemiGlobal& search, int first_block, int last_block, int first_row, int last_row, bool up,
                       const SemiGlobalVolume& volume);
/// Step 3: the candidates of one row for columns [first_column, last_column): the best of its sums, with the meaning it has in MatchRow.
/// cost, before and after are for the sub-pixel part alone: costs of step 1 summed over columns of the row, `sub_pixel_step` apart up to
/// `sub_pixel_reach` to either side (beyond the search stands what is at its borders); cost is the least of the three. Sums of paths lean
/// to where the paths come from, which is 0.16 px on a floor with 3 of them. Without `fresh` the last call with this work space was for a
/// row of the same search.
using PathsRow = void(const SemiGlobal& search, int row, bool fresh, const SemiGlobalVolume& volume, uint8_t* work, const Candidates& out);

namespace plain {
SparseCensus sparse_census;
PathsAcross paths_across;
PathsDown paths_down;
PathsRow paths_row;
}  // namespace plain

}  // namespace vdisp::kernels
