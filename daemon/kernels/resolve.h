// resolve.h: contracts: from the candidates of one or two hypotheses to a row of disparities, or why a pixel has none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "daemon/kernels/block_match.h"
#include "daemon/kernels/shear.h"

namespace vdisp::kernels {

/// What one hypothesis found in a row.
struct Hypothesis {
  Candidates candidates;
  int first = 0, last = 0;  ///< columns that have a candidate
  int min_disparity = 0;    ///< px, of index 0
};

/// What the pixels of one row are asked, and how a refusal is written.
struct Resolve {
  int width = 0;
  int min_disparity = 0, disparities = 0;  ///< px: what leaves this range is outside
  int unique = 0;        ///< part of its cost by which a match must beat the other hypothesis' (percent_factor); 0: not asked
  int floor_margin = 0;  ///< part by which what is off the floor must beat the floor itself, not asked if unique is 0
  int texture_least = 0;
  int16_t outside = 0, low_texture = 0, not_unique = 0, left_right = 0;
};
/// 1/16 px: disparities of two hypotheses are the same up to the one, and off the floor above the other.
inline constexpr int same_disparity = 16, off_floor = 24;

/// 1/16 px: a floor nearer or farther than this is taken as this near or far, outside of any search; what hypotheses say is counted from
/// it in 16 bits, so that their min_disparity is -256 .. 256.
inline constexpr int most_floor = 16 * 1024;
inline int floor_at(const RowDisparity& floor_disparity, int column) {
  return std::clamp(floor_disparity.at(column), -most_floor, most_floor);
}

/// Writes out[0 .. width): the disparity in 1/16 px, or the reason. Pixels outside [plain.first, plain.last) are outside.
/// Of the candidates up to row_margin elements behind `last` are read, whatever they hold.
///
/// `floor` is null, or the search in the view sheared by `floor_disparity`: its disparities are those plus floor_at(x), and its home,
/// which must be there, is the floor itself. Of two hypotheses that say the same (same_disparity) the one that is not refused is taken,
/// else the cheaper; of two that differ the cheaper, if it is so by `unique`. What is taken and lies off the floor (off_floor) must be
/// cheaper than the floor by floor_margin: else the floor explains the pixel nearly as well, and the match is not unique.
///
/// Sub-pixel: the least of two lines of equal slope through the best cost and its neighbours, as fits sums of absolute differences,
/// rounded to 1/16 px.
using ResolveRow = void(const Resolve& resolve, const Hypothesis& plain, const Hypothesis* floor, const RowDisparity& floor_disparity,
                        const uint16_t* texture, int16_t* out);

namespace plain {
ResolveRow resolve_row;
}

}  // namespace vdisp::kernels
