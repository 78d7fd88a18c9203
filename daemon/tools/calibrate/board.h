// board.h: the calibration board: where its corners are, and how they are found in an image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "daemon/tools/calibrate/words.h"

namespace vdisp::calibrate {

/// Corners found in one image, each with its number on the board.
struct BoardView {
  std::vector<int> ids;
  std::vector<cv::Point2f> corners;  ///< px; whole numbers are the middles of pixels
  bool empty() const { return ids.empty(); }
};

class Board {
 public:
  /// Throws ToolError (64) where size, kind or dictionary are none.
  explicit Board(const BoardOptions& options);

  int corners() const { return (columns_ - (charuco_ ? 1 : 0)) * (rows_ - (charuco_ ? 1 : 0)); }
  double square() const { return square_; }
  /// Places on the board, m, z = 0.
  std::vector<cv::Point3f> places(const std::vector<int>& ids) const;
  /// Numbers of corners one square apart.
  std::vector<std::pair<int, int>> neighbours() const;
  /// The corners in `gray`, to a fraction of a pixel; empty where there is no board: all of a chessboard, or at least 8 of a ChArUco board.
  BoardView find(const cv::Mat& gray) const;
  /// A chessboard that looks the same upside down may be numbered from its other end in one of the views.
  void agree(const BoardView& left, BoardView& right) const;

 private:
  int across() const { return columns_ - (charuco_ ? 1 : 0); }
  BoardView find_chessboard(const cv::Mat& gray) const;
  BoardView find_charuco(const cv::Mat& gray) const;

  bool charuco_;
  int columns_ = 0, rows_ = 0, dictionary_ = 0;
  double square_, marker_;
};

/// What both views have, in one order.
void keep_common(BoardView& left, BoardView& right);

}  // namespace vdisp::calibrate
