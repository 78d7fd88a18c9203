// row_matches.h: the same features in both rectified views, to a fraction of a pixel: what rows and the order of the views are judged by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace vdisp::calibrate {

struct RowMatch {
  cv::Point2f left, right;
  double rows() const { return static_cast<double>(right.y) - static_cast<double>(left.y); }  ///< px, positive: lower in the right view
  double disparity() const { return static_cast<double>(left.x) - static_cast<double>(right.x); }
};

/// Corners of the left view that have one counterpart in the right one, to either side and up to an eighth of the height higher or lower.
/// Found by normalised correlation, refined by optical flow, which has to lead back.
std::vector<RowMatch> match_rows(const cv::Mat& left, const cv::Mat& right);

}  // namespace vdisp::calibrate
