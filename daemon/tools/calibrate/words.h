// words.h: the words of vdisp-calibrate, what they are asked, and how they fail.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/geometry/calibration.h"

namespace vdisp::calibrate {

/// One line: what was found, where, what would be right.
class ToolError : public std::runtime_error {
 public:
  ToolError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// A board: inner corners of a chessboard, or squares of a ChArUco board.
struct BoardOptions {
  std::string size, kind = "chessboard", dictionary = "DICT_5X5_100";
  double square_m = 0, marker_m = 0;
};

struct Options {
  std::string input, output, format, size;
  ReadingOptions reading;
  bool json = false, window = false;
  std::string left, right;
  BoardOptions board;
  std::string report;
  double most_rms = 0.5;  ///< px
  std::string calibration, config;
  std::vector<std::string> sets;
  int most_pairs = 20;
  std::string name = "IPLObstacleDetection";
  int views = 20;
  double seconds = 0;  ///< 0: without limit
};

/// Each returns the exit code, and throws ToolError, CalibrationError, SourceError or WriteError.
int convert(const Options& options);
int show(const Options& options);
int solve(const Options& options);
int check(const Options& options);
int capture(const Options& options);

}  // namespace vdisp::calibrate
