// findings.h: what check() found out: each with its numbers, and where it is a fault, with the fix.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/tools/calibrate/board.h"
#include "daemon/tools/calibrate/misalignment.h"
#include "daemon/tools/calibrate/stage_run.h"

namespace vdisp::calibrate {

/// doubt: worth a line, and no reason to stop. fact: there is nothing to judge.
enum class Verdict { fine, fault, doubt, unknown, fact };

struct Finding {
  std::string name;  ///< one word, also for JSON: order, rows, shift, rotation, size, scale, pitch, height, blind, ...
  Verdict verdict;
  std::string text;  ///< what was found
  std::string fix;   ///< of a fault, or what would make the unknown known
  double value;      ///< NaN where there is no single number
};
using Findings = std::vector<Finding>;

/// What is compared: whether vdisp.cfg tells pitch and height at all is for the caller to know.
struct Expected {
  double pitch, height;  ///< rad, m; NaN: nothing to compare with
};

constexpr size_t fewest_matches = 40;
constexpr double most_row_error = 0.5;  ///< px, median: the matcher has half a row to spare

Finding exchanged_views(const std::string& why);
/// Which of the views is the left one. False: they are exchanged, and all else would be nonsense.
bool find_order(const StageRun& run, const std::vector<RowMatch>& matches, const StereoView& view, Findings& findings);
/// Rows, shift, rotation, size of the right view against the left one.
void find_misalignment(const std::vector<RowMatch>& matches, const StereoView& view, const cv::Size& size, bool calibrated,
                       Findings& findings);
/// Squares of a board that is seen, against what they are. Returns measured / true; NaN where no board is seen.
double find_scale(const StageRun& run, const Board& board, const StereoView& view, Findings& findings);
/// Pitch and height by the floor. `scale` as find_scale() found it.
void find_mounting(const StageRun& run, const Expected& expected, double scale, const StereoView& view, Findings& findings);
/// Blind band, range errors and smallest obstacles: no verdicts, but what this camera can do.
void find_abilities(const StageRun& run, const Config& config, double pitch, double height, Findings& findings);

}  // namespace vdisp::calibrate
