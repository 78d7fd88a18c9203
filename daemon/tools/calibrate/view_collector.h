// view_collector.h: which views of a board are worth taking: at rest, seen whole by both cameras, and unlike those taken before.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "daemon/tools/calibrate/board.h"

namespace vdisp::calibrate {

/// How a board lies in the image, without any calibration: fractions of the image, and how much longer one side looks than the other.
struct Appearance {
  double x = 0, y = 0, size = 0;  ///< middle and square root of the area, fractions
  double across = 0, down = 0;    ///< logarithm of left by right and of top by bottom: perspective
};

enum class Look { taken, no_board, moving, known };

class ViewCollector {
 public:
  ViewCollector(const Board& board, const cv::Size& size, size_t wanted) : board_(board), size_(size), wanted_(wanted) {}
  /// The next pair, boards empty where none was found. taken: it is worth keeping, and counted.
  Look consider(const BoardView& left, const BoardView& right);
  size_t taken() const { return appearances_.size(); }
  /// Enough views, a corner in every ninth of the image, and the board tilted to all sides.
  bool complete() const { return taken() >= wanted_ && missing().empty(); }
  /// What to show next, in one line; empty: only more of the same.
  std::string missing() const;
  /// Corners so far in the ninths of the left image.
  const std::array<int, 9>& cells() const { return cells_; }

 private:
  Appearance appearance(const BoardView& view) const;

  const Board& board_;
  cv::Size size_;
  size_t wanted_;
  std::vector<Appearance> appearances_;
  std::array<int, 9> cells_{};
  BoardView last_[2];
};

}  // namespace vdisp::calibrate
