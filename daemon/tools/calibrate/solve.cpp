// solve.cpp: the word `solve`: pairs of images of a board to a calibration, with a verdict on each view.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/geometry/calibration_write.h"
#include "daemon/sources/pair_readers.h"
#include "daemon/tools/calibrate/files_out.h"
#include "daemon/tools/calibrate/judgement.h"
#include "daemon/tools/calibrate/pairs.h"
#include "daemon/tools/calibrate/report.h"
#include "daemon/tools/calibrate/rotation.h"
#include "daemon/tools/calibrate/stereo_solution.h"

namespace vdisp::calibrate {
namespace {

constexpr double degrees = 180 / std::numbers::pi;

std::string base(const std::string& path) { return std::filesystem::path(path).filename().string(); }

/// Finds the boards in a pair. `size` is that of the first pair.
View look(const Board& board, ImagePairs& pairs, bool readable, cv::Size& size) {
  View view;
  const auto names = pairs.names();
  view.left = base(names.first), view.right = base(names.second);
  if (!readable) {
    view.rejected = pairs.problem();
    return view;
  }
  if (size.empty()) size = pairs.left().size();
  if (pairs.left().size() != size) {
    view.rejected = "is " + size_text(pairs.left().size()) + ", the first pair is " + size_text(size);
    return view;
  }
  view.board = {board.find(pairs.left()), board.find(pairs.right())};
  const bool left = !view.board[0].empty(), right = !view.board[1].empty();
  if (!left || !right) {
    view.rejected = std::string("no board found in ") + (left ? "the right view" : right ? "the left view" : "either view");
    return view;
  }
  board.agree(view.board[0], view.board[1]);
  keep_common(view.board[0], view.board[1]);
  if (view.board[0].ids.size() < 6) view.rejected = "the views have too few corners in common";
  return view;
}

nlohmann::json to_json(const Solution& s, const std::vector<View>& views) {
  const Stand stand = stand_of(s.calibration);
  const auto turn = rotation_vector(stand.rotation);
  nlohmann::json out{{"rms_px", s.rms},
                     {"rows_median_px", s.rows_median},
                     {"rows_p95_px", s.rows_p95},
                     {"f_deviation", s.f_deviation},
                     {"usable", s.faults.empty()},
                     {"faults", s.faults},
                     {"advice", s.advice},
                     {"baseline_m", s.calibration.view.baseline},
                     {"rotation_deg", {degrees * turn[0], degrees * turn[1], degrees * turn[2]}},
                     {"fx", {(*s.calibration.raw)[0].k[0], (*s.calibration.raw)[1].k[0]}},
                     {"cells", s.cells}};
  for (const View& view : views)
    out["views"].push_back({{"left", view.left},
                            {"right", view.right},
                            {"used", view.used()},
                            {"rejected", view.rejected},
                            {"rms_left_px", view.rms[0]},
                            {"rms_right_px", view.rms[1]},
                            {"rows_px", view.rows}});
  return out;
}

void print(const std::vector<View>& views) {
  std::printf("%-24s %-24s %6s %6s %6s\n", "left", "right", "left", "right", "rows");
  for (const View& view : views) {
    std::printf("%-24s %-24s ", view.left.c_str(), view.right.c_str());
    if (view.used())
      std::printf("%6.2f %6.2f %6.2f\n", view.rms[0], view.rms[1], view.rows);
    else
      std::printf("rejected: %s\n", view.rejected.c_str());
  }
}

void print(const Solution& s) {
  const Stand stand = stand_of(s.calibration);
  const auto turn = rotation_vector(stand.rotation);
  std::printf("\nreprojection %.3f px, rows after rectification %.3f px (median), %.3f (95 %%)\n", s.rms, s.rows_median, s.rows_p95);
  for (int i : {0, 1}) {
    const auto& k = (*s.calibration.raw)[i].k;
    std::printf("%-12s fx %.2f, fy %.2f, centre %.2f, %.2f px\n", i == 0 ? "left" : "right", k[0], k[4], k[2], k[5]);
  }
  std::printf("f            known to %.2f %%\n", 100 * s.f_deviation);
  std::printf("baseline     %.3f mm; the right camera is turned by %.3f, %.3f, %.3f deg about x, y, z\n",
              1000 * s.calibration.view.baseline, degrees * turn[0], degrees * turn[1], degrees * turn[2]);
  std::printf("corners in the ninths of the left image: %d %d %d / %d %d %d / %d %d %d\n", s.cells[0], s.cells[1], s.cells[2], s.cells[3],
              s.cells[4], s.cells[5], s.cells[6], s.cells[7], s.cells[8]);
  for (const std::string& advice : s.advice) std::printf("better: %s\n", advice.c_str());
}

}  // namespace

int solve(const Options& options) {
  const Board board(options.board);
  const CalibrationFormat format = options.output.empty() ? CalibrationFormat::opencv : format_for(options.output, options.format);
  ImagePairs pairs(pairs_of(options.left, options.right));
  pairs.survey(10);
  std::vector<View> views;
  cv::Size size;
  for (PairRead read = pairs.next(); read != PairRead::end; read = pairs.next()) {
    views.push_back(look(board, pairs, read == PairRead::good, size));
    if (isatty(STDERR_FILENO))
      std::fprintf(stderr, "%s: %s\n", views.back().left.c_str(), views.back().used() ? "found" : views.back().rejected.c_str());
  }
  Solution solution;
  try {
    solution = solve_stereo(board, size, views, options.most_rms);
  } catch (const ToolError&) {
    if (!options.json) print(views);
    throw;
  }
  if (options.json)
    std::cout << to_json(solution, views).dump(2) << '\n';
  else
    print(views), print(solution);
  const bool told = std::fflush(stdout) == 0 && std::cout.flush();
  if (!options.report.empty()) write_report(options.report, solution, views);
  if (!solution.faults.empty()) throw ToolError(EX_CONFIG, refusal(solution));
  if (!options.output.empty()) {
    write_calibration(solution.calibration, format, options.output);
    if (!options.json) std::cout << options.output << ": written\n";
  }
  if (!told) throw ToolError(EX_IOERR, "standard output cannot be written");
  return EX_OK;
}

}  // namespace vdisp::calibrate
