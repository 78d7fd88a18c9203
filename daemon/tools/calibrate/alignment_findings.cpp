// alignment_findings.cpp: findings of the matches: order of the views, rows, shift, rotation, size.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "daemon/sources/view_order.h"
#include "daemon/tools/calibrate/findings.h"
#include "ipc/outlet.h"

namespace vdisp::calibrate {
namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr double most_rows = most_row_error, most_shift = 0.5;  // px
constexpr double most_roll_deg = 0.1;                           // half a row at the side of a usual image
constexpr double most_yaw_deg = 0.25, most_corner = 1.7;        // px: kitti_street, rectified by its makers, has 0.6 deg and 1.6 px of it
constexpr double most_scale = 0.003;                            // likewise
constexpr size_t fewest = fewest_matches;
constexpr double surely_apart = 1.5, share_exchanged = 0.8;  // px of disparity on the wrong side of infinity
constexpr const char* again =
    "calibrate again with vdisp-calibrate solve: the cameras have moved against each other, or this is not their calibration";

template <class... Values>
std::string text(const char* format, Values... values) {
  char line[300];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// The daemon's own judge of the order wants its images.
std::optional<bool> left_is_first(const StageRun& run) {
  ViewOrder order;
  std::optional<bool> verdict;
  for (const StagedPair& pair : run.pairs) {
    const ImageSpec spec{Pixel::gray8, 0, static_cast<uint16_t>(pair.camera[0].cols), static_cast<uint16_t>(pair.camera[0].rows)};
    BufferOutlet outlets[2] = {BufferOutlet(spec), BufferOutlet(spec)};
    for (int i : {0, 1})
      for (int y = 0; y < spec.height; ++y) std::copy_n(pair.camera[i].ptr(y), spec.width, outlets[i].loan().row<uint8_t>(y));
    if (!verdict) order.prepare(spec);
    verdict = order.see(outlets[0].loan(), outlets[1].loan());
    if (verdict) break;
  }
  return verdict;
}

}  // namespace

Finding exchanged_views(const std::string& why) {
  return {"order", Verdict::fault, "the views are exchanged: " + why,
          "exchange left and right in [image source], or the cables; nothing else was measured", NAN};
}

bool find_order(const StageRun& run, const std::vector<RowMatch>& matches, const StereoView& view, Findings& findings) {
  size_t right = 0, wrong = 0;
  for (const RowMatch& match : matches) {
    const double d = match.disparity() - view.cx_offset;
    if (d > surely_apart) ++right;
    if (d < -surely_apart) ++wrong;
  }
  const double share = static_cast<double>(wrong) / std::max<double>(1, static_cast<double>(right + wrong));
  const bool told = right + wrong >= fewest;
  const std::optional<bool> seen = told ? std::nullopt : left_is_first(run);
  if ((told && share > share_exchanged) || (seen && !*seen)) {
    findings.push_back(exchanged_views(told ? text("%zu of %zu matches lie beyond infinity", wrong, right + wrong)
                                            : "what is near lies farther to the left in the view that is called left"));
    return false;
  }
  if (!told && !seen)
    findings.push_back({"order", Verdict::unknown, text("too few matches (%zu) to tell left from right", matches.size()),
                        "take pairs with things near the camera and more texture", NAN});
  else
    findings.push_back({"order", Verdict::fine, "left is left and right is right", "", share});
  return true;
}

void find_misalignment(const std::vector<RowMatch>& matches, const StereoView& view, const cv::Size& size, bool calibrated,
                       Findings& findings) {
  if (matches.size() < fewest) {
    findings.push_back({"rows", Verdict::unknown, text("%zu features are found in both views, needed are %zu", matches.size(), fewest),
                        "take pairs with more texture, or more of them", NAN});
    return;
  }
  const Misalignment m = fit_misalignment(matches, view);
  const auto judged = [&findings](const char* name, Verdict verdict, const std::string& what, double value) {
    findings.push_back({name, verdict, what, verdict == Verdict::fine ? "" : again, value});
  };
  const auto add = [&judged](const char* name, bool fault, const std::string& what, double value) {
    judged(name, fault ? Verdict::fault : Verdict::fine, what, value);
  };
  add("rows", m.median_px > most_rows,
      text("rows of %zu matches differ by %.2f px (median), at most %.1f is good; %.2f px would remain without what follows", m.matches,
           m.median_px, most_rows, m.remaining_px),
      m.median_px);
  const double shift_deg = degrees * std::atan(m.shift_px / view.f);
  add("shift", std::abs(m.shift_px) > most_shift,
      text("vertical shift: the right view is %.2f px too %s%s", std::abs(m.shift_px), m.shift_px > 0 ? "low" : "high",
           calibrated ? text(" (as if the right camera were turned by %.2f deg about x)", -shift_deg).c_str() : ""),
      m.shift_px);
  const double roll = degrees * m.roll_rad, yaw = degrees * m.yaw_rad;
  add("rotation", std::abs(roll) > most_roll_deg,
      text("rotation: the right camera is turned by %.2f deg about its view (z) against the calibration", roll), roll);
  const double corner = std::abs(m.yaw_rad) * size.width * size.height / (4 * view.f);
  judged("yaw",
         std::abs(yaw) <= most_yaw_deg ? Verdict::fine
         : corner > most_corner        ? Verdict::fault
                                       : Verdict::doubt,
         text("rotation: rows in the corners differ by %.1f px, as if the right camera were turned by %.2f deg about the upright (y)",
              corner, yaw),
         yaw);
  add("size", std::abs(m.scale) > most_scale,
      text("size: the right view is %.2f %% %s than the left one", 100 * std::abs(m.scale), m.scale > 0 ? "larger" : "smaller"), m.scale);
}

}  // namespace vdisp::calibrate
