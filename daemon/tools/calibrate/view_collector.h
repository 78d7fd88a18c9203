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

/// What a view that was taken adds.
struct TakenView {
  Appearance appearance;
  std::array<int, 9> cells{};            ///< corners in the ninths of the left image
  std::array<cv::Point2f, 4> outline{};  ///< outermost corners in the left image, px, around the board
};

/// Tilts that a calibration needs: a side of the board nearer than the other. In the order of `tilt_names`.
constexpr size_t tilts = 4;
extern const char* const tilt_names[tilts];

class ViewCollector {
 public:
  ViewCollector(const Board& board, const cv::Size& size, size_t wanted) : board_(board), size_(size), wanted_(wanted) {}
  /// The next pair, boards empty where none was found. taken: it is worth keeping, and counted. `asked`: the operator wants it, moving or
  /// known as it may be.
  Look consider(const BoardView& left, const BoardView& right, bool asked = false);
  /// Forgets the last one taken; the like of it is taken again only where it is asked for.
  void undo();
  size_t taken() const { return views_.size(); }
  /// Enough views, a corner in every ninth of the image, and the board tilted to all sides.
  bool complete() const { return taken() >= wanted_ && missing().empty(); }
  /// What to show next, in one line; empty: only more of the same.
  std::string missing() const;
  /// Corners so far in the ninths of the left image.
  const std::array<int, 9>& cells() const { return cells_; }
  /// Enough of them in this ninth.
  bool covered(size_t cell) const;
  bool tilted(size_t tilt) const;
  const std::vector<TakenView>& views() const { return views_; }

 private:
  TakenView described(const BoardView& view) const;

  const Board& board_;
  cv::Size size_;
  size_t wanted_;
  std::vector<TakenView> views_, undone_;
  std::array<int, 9> cells_{};
  BoardView last_[2];
};

}  // namespace vdisp::calibrate
