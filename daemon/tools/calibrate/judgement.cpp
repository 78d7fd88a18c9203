// judgement.cpp: judges a solution by its errors, by how much of the image the boards covered, and by how they were tilted.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/judgement.h"

#include <algorithm>
#include <cstdio>

namespace vdisp::calibrate {

const char* const cell_names[9] = {"upper left", "top",        "upper right", "left side",  "middle",
                                   "right side", "lower left", "bottom",      "lower right"};

namespace {

constexpr double most_rows = 0.5;           // px, median: block matching has half a row to spare
constexpr double most_f_deviation = 0.005;  // of f: half a percent of every range
constexpr double tilted = 0.2;              // rad: less hardly tells f from distance
constexpr int fewest_in_cell = 10, most_empty = 4;
constexpr size_t good_count = 10;

void count_cells(Solution& solution, const std::vector<View>& views) {
  for (const View& view : views) {
    if (!view.used()) continue;
    for (const cv::Point2f& corner : view.board[0].corners) {
      const int column = std::clamp(static_cast<int>(3 * corner.x / static_cast<float>(solution.size.width)), 0, 2);
      const int row = std::clamp(static_cast<int>(3 * corner.y / static_cast<float>(solution.size.height)), 0, 2);
      ++solution.cells[static_cast<size_t>(3 * row + column)];
    }
  }
}

template <class... Values>
std::string text(const char* format, Values... values) {
  char line[200];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

void advise_poses(Solution& solution, const std::vector<View>& views) {
  struct Pose {
    double View::*angle;
    int sign;
    const char* how;
  };
  const Pose poses[] = {{&View::tilt_across, 1, "turned to one side by 30 deg"},
                        {&View::tilt_across, -1, "turned to the other side by 30 deg"},
                        {&View::tilt_down, 1, "tilted back by 30 deg"},
                        {&View::tilt_down, -1, "tilted forward by 30 deg"}};
  for (const Pose& pose : poses) {
    const bool seen =
        std::any_of(views.begin(), views.end(), [&](const View& view) { return view.used() && pose.sign * view.*pose.angle > tilted; });
    if (!seen) solution.advice.push_back(std::string("add views with the board ") + pose.how);
  }
}

}  // namespace

void judge(Solution& solution, const std::vector<View>& views, double most_rms) {
  count_cells(solution, views);
  const auto used = static_cast<size_t>(std::count_if(views.begin(), views.end(), [](const View& view) { return view.used(); }));
  std::string thin;
  int empty = 0;
  for (size_t i = 0; i < 9; ++i) {
    if (solution.cells[i] >= fewest_in_cell) continue;
    thin += (thin.empty() ? "" : ", ") + std::string(cell_names[i]);
    ++empty;
  }
  if (solution.rms > most_rms)
    solution.faults.push_back(text("reprojection error is %.2f px, at most %.2f is usable", solution.rms, most_rms));
  if (solution.rows_median > most_rows)
    solution.faults.push_back(text("rows differ by %.2f px after rectification, at most %.2f is usable", solution.rows_median, most_rows));
  if (solution.f_deviation > most_f_deviation)
    solution.faults.push_back(text("f is known to %.1f %% only, needed are %.1f", 100 * solution.f_deviation, 100 * most_f_deviation));
  if (empty > most_empty) solution.faults.push_back("hardly a corner in these parts of the image: " + thin);
  if (!thin.empty()) solution.advice.push_back("add views with the board in these parts of the left image: " + thin);
  advise_poses(solution, views);
  if (used < good_count) solution.advice.push_back(text("add views: %zu are used, 15 are better", used));
  if (solution.rms > most_rms || solution.rows_median > most_rows)
    solution.advice.push_back("take still pictures of a flat board, both cameras at the same moment, and see that --board is right");
}

std::string refusal(const Solution& solution) {
  const auto joined = [](const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) all += (all.empty() ? "" : "; ") + line;
    return all;
  };
  return "not usable, nothing written: " + joined(solution.faults) + ". Needed: " + joined(solution.advice);
}

}  // namespace vdisp::calibrate
