// metric_findings.cpp: findings in metres: a board's squares, pitch and height by the floor, and what the camera can see at all.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "daemon/tools/calibrate/findings.h"

namespace vdisp::calibrate {
namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr double most_scale = 0.02, most_height = 0.05;  // fractions
constexpr double most_pitch = 0.03;                      // rad: 0.15 m of height at 5 m
constexpr double matching_error = 0.25;                  // px, of a good match on the real sets

template <class... Values>
std::string text(const char* format, Values... values) {
  char line[400];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

cv::Vec3d place(const StereoView& view, const cv::Point2f& left, const cv::Point2f& right) {
  const Point p = view.point(left.x, 0.5 * (left.y + right.y), left.x - right.x);
  return {p.x, p.y, p.z};
}

/// Mean length of the squares' sides of the board in one pair; NaN where it is not seen.
double measured_square(const Board& board, const StereoView& view, const StagedPair& pair) {
  BoardView left = board.find(pair.rectified[0]), right = board.find(pair.rectified[1]);
  if (left.empty() || right.empty()) return NAN;
  board.agree(left, right);
  keep_common(left, right);
  std::vector<int> where(static_cast<size_t>(board.corners()), -1);
  for (size_t i = 0; i < left.ids.size(); ++i) where[static_cast<size_t>(left.ids[i])] = static_cast<int>(i);
  // Corners far apart, so that noise along the view counts little.
  double sum = 0;
  int count = 0;
  for (size_t a = 0; a < left.ids.size(); ++a)
    for (size_t b = a + 1; b < left.ids.size(); ++b) {
      const auto ideal = board.places({left.ids[a], left.ids[b]});
      const double apart = cv::norm(ideal[0] - ideal[1]);
      if (apart < 3 * board.square()) continue;
      sum += cv::norm(place(view, left.corners[a], right.corners[a]) - place(view, left.corners[b], right.corners[b])) / apart;
      ++count;
    }
  return count ? sum / count * board.square() : NAN;
}

void compare_height(double height, const Expected& expected, double scale, const StereoView& view, Findings& findings) {
  const double off = height / expected.height - 1;
  if (std::abs(off) <= most_height) {
    findings.push_back(
        {"height", Verdict::fine, text("camera height by the floor is %.3f m, vdisp.cfg says %.3f", height, expected.height), "", height});
    return;
  }
  const double baseline = 1000 * view.baseline;
  std::string fix;
  if (std::isnan(scale))
    fix = text(
        "measure the height: if it is %.3f m, the baseline is wrong, %.1f mm instead of %.1f would fit, and vdisp-calibrate solve finds "
        "it; else "
        "set [mounting] height = %.3f. A board (--board, --square) tells the two apart",
        expected.height, baseline / (1 + off), baseline, height);
  else if (std::abs(scale - 1) > most_scale)
    fix = "the board tells that the baseline is wrong, see scale";
  else
    fix = text("set [mounting] height = %.3f: the board tells that the scale is right", height);
  findings.push_back({"height", Verdict::fault,
                      text("camera height by the floor is %.3f m, vdisp.cfg says %.3f: %+.1f %%", height, expected.height, 100 * off), fix,
                      height});
}

}  // namespace

double find_scale(const StageRun& run, const Board& board, const StereoView& view, Findings& findings) {
  std::vector<double> squares;
  for (const StagedPair& pair : run.pairs)
    if (const double square = measured_square(board, view, pair); std::isfinite(square)) squares.push_back(square);
  if (squares.empty()) {
    findings.push_back({"scale", Verdict::unknown, "the board is not seen in both views of any pair",
                        "hold the board before both cameras, near enough", NAN});
    return NAN;
  }
  const double scale = median(squares) / board.square();
  const std::string what = text("squares of the board measure %.2f mm in %zu pairs, and are %.2f mm: %+.1f %%", 1000 * median(squares),
                                squares.size(), 1000 * board.square(), 100 * (scale - 1));
  if (std::abs(scale - 1) <= most_scale)
    findings.push_back({"scale", Verdict::fine, what, "", scale});
  else
    findings.push_back(
        {"scale", Verdict::fault, what,
         text(
             "the baseline is wrong: %.1f mm instead of %.1f would fit; calibrate again with vdisp-calibrate solve, and the right --square",
             1000 * view.baseline / scale, 1000 * view.baseline),
         scale});
  return scale;
}

void find_mounting(const StageRun& run, const Expected& expected, double scale, const StereoView& view, Findings& findings) {
  std::vector<double> pitches, heights, rolls;
  for (const StagedPair& pair : run.pairs) {
    if (pair.floor.state != FloorState::found || std::isnan(pair.floor.height_m)) continue;
    pitches.push_back(pair.floor.pitch_rad);
    heights.push_back(pair.floor.height_m);
    rolls.push_back(pair.floor.roll_rad);
  }
  if (2 * pitches.size() < run.pairs.size() || pitches.empty()) {
    findings.push_back({"floor", Verdict::unknown, text("a floor is found in %zu of %zu pairs", pitches.size(), run.pairs.size()),
                        "take pairs of flat, textured ground without much on it", NAN});
    return;
  }
  const double pitch = median(pitches), height = median(heights);
  findings.push_back(
      {"roll", Verdict::fact, text("roll by the floor is %.3f rad (%.1f deg)", median(rolls), degrees * median(rolls)), "", median(rolls)});
  if (std::isnan(expected.pitch))
    findings.push_back({"pitch", Verdict::fact, text("pitch by the floor is %.3f rad (%.1f deg)", pitch, degrees * pitch), "", pitch});
  else
    findings.push_back(
        {"pitch", std::abs(pitch - expected.pitch) > most_pitch ? Verdict::fault : Verdict::fine,
         text("pitch by the floor is %.3f rad (%.1f deg), vdisp.cfg says %.3f (%.1f)", pitch, degrees * pitch, expected.pitch,
              degrees * expected.pitch),
         std::abs(pitch - expected.pitch) > most_pitch ? text("set angRot = %.3f in [Limit obstacle] and [Map], or auto", pitch) : "",
         pitch});
  if (std::isnan(expected.height))
    findings.push_back({"height", Verdict::fact, text("camera height by the floor is %.3f m", height), "", height});
  else
    compare_height(height, expected, scale, view, findings);
}

void find_abilities(const StageRun& run, const Config& config, double pitch, double height, Findings& findings) {
  const StereoView& view = run.calibration->view;
  const auto& p = config.image_source;
  const cv::Size size = run.pairs[0].rectified[0].size();
  const double nearest = nearest_matched(view, p.minDisparity + p.ndisp);
  if (std::isfinite(pitch) && std::isfinite(height)) {
    const double half_view = std::atan((size.height - view.cy) / view.f);
    const double seen = std::max(0.0, nearest_floor(height, pitch, half_view)),
                 matched = std::max(seen, floor_ahead(nearest, height, pitch));
    const double depth = seen * std::cos(pitch) + height * std::sin(pitch);
    const int enough = static_cast<int>(std::ceil((view.disparity(depth) - p.minDisparity) / 16)) * 16;
    findings.push_back(
        {"blind", Verdict::fact,
         matched > seen ? text("blind band: the floor is seen from %.2f m ahead and matched from %.2f m; ndisp = %d would match all of it",
                               seen, matched, enough)
                        : text("blind band: none, the floor is matched from where it is seen, %.2f m ahead", seen),
         "", matched - seen});
  }
  for (double z : {1.0, 2.0, 3.0, 5.0}) {
    const double error = z * z / (view.f * view.baseline), px = z / view.f;
    if (z < nearest) {
      findings.push_back({text("at_%.0f_m", z), Verdict::fact,
                          text("at %.0f m: nearer than can be matched (%.2f m, ndisp = %d)", z, nearest, p.ndisp), "", NAN});
      continue;
    }
    // Half the window shows it: less is outvoted by what is behind.
    const double across = 0.5 * p.corrsize * px, up = std::max({config.limit.max_height, across, p.SpeckleSize * px * px / across});
    findings.push_back(
        {text("at_%.0f_m", z), Verdict::fact,
         text("at %.0f m: range error %.0f mm (a quarter of a pixel; a step is %.1f mm), smallest obstacle %.0f mm wide and %.0f mm high",
              z, 1000 * matching_error * error, 1000 * error / 16, 1000 * across, 1000 * up),
         "", matching_error * error});
  }
}

}  // namespace vdisp::calibrate
