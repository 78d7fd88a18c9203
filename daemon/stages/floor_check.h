// floor_check.h: part of `disparity`: refuses matches where the floor explains the image as well.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "config/config.h"
#include "daemon/stages/provisional_floor.h"

namespace vdisp {

/// A floor is slanted: in a square window its true disparity fits badly, and a wrong, nearer one may fit better and pass every other
/// filter: ground becomes an obstacle. So the floor that the matches of this frame show is put to the test as a whole: where a
/// match lies off it, and the right view shifted row by row by the floor's disparity agrees with the left one about as well, the match
/// is not unique.
class FloorCheck {
 public:
  FloorCheck(Machine& machine, const Config& config);
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& disparity);
  /// `disparity` as matched so far, its header complete.
  void refuse(const cv::Mat& left, const cv::Mat& right, Image& disparity) noexcept;

 private:
  bool find_floor(const Image& disparity) noexcept;
  void measure(const cv::Mat& left, const cv::Mat& right, const Image& disparity) noexcept;

  const Config& config_;
  ProvisionalFloor provisional_;
  std::vector<int> shift_;  // of the floor, for each row, 1/16 px
  cv::Mat gradient_, left_gradient_, right_gradient_;
  cv::Mat off_floor_, off_match_, floor_cost_, match_cost_;
};

}  // namespace vdisp
