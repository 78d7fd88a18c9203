// stereo_solution.h: from boards seen by both cameras to their calibration, and how far it is to be trusted.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "daemon/geometry/calibration.h"
#include "daemon/tools/calibrate/board.h"

namespace vdisp::calibrate {

/// One pair of images: what was seen in it, and what became of it.
struct View {
  std::string left, right;                ///< names of the images
  std::array<BoardView, 2> board;         ///< the same corners in both
  std::string rejected;                   ///< why it is not used; empty: it is
  std::array<double, 2> rms{};            ///< reprojection error, px
  double rows = 0;                        ///< median distance of the rows after rectification, px
  double tilt_across = 0, tilt_down = 0;  ///< of the board towards the left camera, rad: turned about the upright, the level axis
  std::array<std::vector<cv::Point2f>, 2> residuals;  ///< seen less expected, px, for each corner
  bool used() const { return rejected.empty(); }
};

struct Solution {
  Calibration calibration;
  cv::Size size;
  double rms = 0;                        ///< of all corners of both views, px
  double rows_median = 0, rows_p95 = 0;  ///< distance of the rows after rectification, px
  double f_deviation = 0;                ///< standard deviation of f, fraction, the worse camera's
  std::array<int, 9> cells{};            ///< corners in the ninths of the left image, row by row
  std::vector<std::string> faults;       ///< why it is not usable; empty: it is
  std::vector<std::string> advice;       ///< which views to add
};

/// Views that fit much worse than the others are marked as rejected, at most a quarter. Throws ToolError: 66 where there are not enough
/// views to try, 78 where they contradict each other altogether.
Solution solve_stereo(const Board& board, const cv::Size& size, std::vector<View>& views, double most_rms);

constexpr int fewest_views = 5;
/// Names of the ninths of the image, row by row.
extern const char* const cell_names[9];

}  // namespace vdisp::calibrate
