// evidence.h: the pixels behind the verdict on a cell of the map, counted.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "probe/reprojection.h"

namespace vdisp {

/// Pixels at the depth of a cell have the disparity of its floor within this: px, and a share of the disparity.
inline constexpr double depth_off = 1.0, depth_share = 0.03;

/// What the pixels of a view are by Surface and by Rejected (0: they have a disparity), and how deep they lie against the cell's floor.
struct Tally {
  std::array<int, 256> surfaces{}, rejected{};
  int nearer = 0, there = 0, farther = 0;
};
/// disparity16 and gray8 of one size, that `view` was made for.
Tally tally_of(const Image& disparity, const Image& surface, const CellView& view);

/// Counts of a map in a cell and its neighbours ahead and behind, by which occupancy goes: disparities of one thing scatter along the
/// line of sight.
int points_around(const Image& map, const MapCell& cell);

/// The pixels of an image of disparities that stand in one cell, and of the surface that tells which of them were filled: where they are,
/// to their last, and their disparities in px.
struct Standing {
  int pixels = 0;
  int filled = 0;  ///< of these, by their edges alone
  int left, right, top, bottom;
  double least, most;
};
Standing standing_in(const MapCell& cell, const Image& disparity, const Image& surface, const Reprojection& reprojection);

}  // namespace vdisp
