// view_collector.cpp: compares what a board looks like with what was seen before.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/view_collector.h"

#include <algorithm>
#include <cmath>

#include "daemon/tools/calibrate/stereo_solution.h"

namespace vdisp::calibrate {
namespace {

constexpr double at_rest = 0.002;  // of the width, from frame to frame: 1.3 px of 640
constexpr double another_view = 0.12;
constexpr double tilted = 0.08;  // perspective of some 20 degrees at usual distances
constexpr int covered = 6;       // corners in a ninth of the image

double motion(const BoardView& a, const BoardView& b) {
  if (a.ids != b.ids || a.empty()) return 1e9;
  double sum = 0;
  for (size_t i = 0; i < a.corners.size(); ++i) sum += cv::norm(a.corners[i] - b.corners[i]);
  return sum / static_cast<double>(a.corners.size());
}

double difference(const Appearance& a, const Appearance& b) {
  return std::hypot(std::hypot(a.x - b.x, a.y - b.y, a.size - b.size), 2 * (a.across - b.across), 2 * (a.down - b.down));
}

}  // namespace

Appearance ViewCollector::appearance(const BoardView& view) const {
  // The outermost corners that are seen, as the board has them.
  const auto places = board_.places(view.ids);
  const auto extreme = [&](float along, float down) {
    size_t best = 0;
    for (size_t i = 1; i < places.size(); ++i)
      if (along * places[i].x + down * places[i].y > along * places[best].x + down * places[best].y) best = i;
    return cv::Point2d(view.corners[best]);
  };
  const cv::Point2d a = extreme(-1, -1), b = extreme(1, -1), c = extreme(1, 1), d = extreme(-1, 1);
  const cv::Point2d middle = 0.25 * (a + b + c + d), one = c - a, other = d - b;
  const auto ratio = [](double x, double y) { return std::log(std::max(x, 1.0) / std::max(y, 1.0)); };
  const double area = 0.5 * std::abs(one.cross(other)), width = size_.width, height = size_.height;
  return {middle.x / width, middle.y / height, std::sqrt(area / (width * height)), ratio(cv::norm(d - a), cv::norm(c - b)),
          ratio(cv::norm(b - a), cv::norm(c - d))};
}

Look ViewCollector::consider(const BoardView& left, const BoardView& right) {
  const double moved = std::max(motion(left, last_[0]), motion(right, last_[1]));
  last_[0] = left;
  last_[1] = right;
  if (left.empty() || right.empty()) return Look::no_board;
  if (moved > at_rest * size_.width) return Look::moving;
  const Appearance now = appearance(left);
  for (const Appearance& before : appearances_)
    if (difference(now, before) < another_view) return Look::known;
  appearances_.push_back(now);
  for (const cv::Point2f& corner : left.corners) {
    const int column = std::clamp(static_cast<int>(3 * corner.x / static_cast<float>(size_.width)), 0, 2);
    const int row = std::clamp(static_cast<int>(3 * corner.y / static_cast<float>(size_.height)), 0, 2);
    ++cells_[static_cast<size_t>(3 * row + column)];
  }
  return Look::taken;
}

std::string ViewCollector::missing() const {
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  for (size_t i = 0; i < 9; ++i)
    if (cells_[i] < covered) add(std::string("board ") + (i == 4 ? "in the " : "at the ") + cell_names[i]);
  const auto seen = [this](double Appearance::*tilt, double sign) {
    return std::any_of(appearances_.begin(), appearances_.end(), [&](const Appearance& a) { return sign * a.*tilt > tilted; });
  };
  if (!seen(&Appearance::across, 1)) add("its left side nearer");
  if (!seen(&Appearance::across, -1)) add("its right side nearer");
  if (!seen(&Appearance::down, 1)) add("its top nearer");
  if (!seen(&Appearance::down, -1)) add("its bottom nearer");
  return text;
}

}  // namespace vdisp::calibrate
