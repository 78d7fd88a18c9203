// block_matcher.h: part of `disparity`: block matching of our own, on absolute differences of gradients or on bits of census codes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "config/config.h"
#include "daemon/stages/matched_views.h"

namespace vdisp {

/// Two gray8 views to disparities with reasons, all filters but that of speckles, by bands of rows.
///
/// Two hypotheses a pixel: that it belongs to a surface seen face on, and that it belongs to the floor. A floor is slanted: its disparity
/// changes from row to row, and a square window fits it badly. So the right view is sheared by the disparities of the floor expected, and
/// matched again in a small range around it; what fits better wins (Einecke and Eggert, IV 2014, for two surfaces).
///
/// What the parameters of SVS (paper table 3) become:
///   ndisp, minDisparity  the disparities searched
///   corrsize             side of the square window
///   thresh               the sum of |x-Sobel|, each at most 31, over the window has to reach thresh * corrsize^2 / 2: the same number
///                        means the same contrast whatever the window, and 10 just refuses noise of 2 grey levels; above the horizon
///                        of the floor expected a quarter more is asked, for there no floor stands against a false match
///   unique               percent by which the best match must be better than any more than 1 px away, as StereoBM counts it: the
///                        differences here are truncated, and 4/5 of it does the same; all of it for prefilter = log and census
class BlockMatcher {
 public:
  BlockMatcher(Machine& machine, const Config& config) : machine_(machine), config_(config), views_(machine, config) {}
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& spec);
  /// `floor`: where it is expected, or null.
  void match(const Image& left, const Image& right, const ExpectedFloor* floor, Image& out) noexcept;

 private:
  /// Work space of one band.
  struct Band {
    kernels::BlockScratch plain, floor;
    std::vector<uint16_t> candidates, texture;
  };
  kernels::BlockSearch plain_search() const;
  kernels::BlockSearch floor_search() const;
  kernels::Hypothesis hypothesis(const kernels::BlockSearch& search, Band& band, int which) const;
  void match_band(const ExpectedFloor* floor, int floor_first, int first, int last, Band& band, Image& out) noexcept;

  Machine& machine_;
  const Config& config_;
  MatchedViews views_;
  std::vector<Band> bands_;
  size_t row_ = 0;  // elements of a row of candidates
};

}  // namespace vdisp
