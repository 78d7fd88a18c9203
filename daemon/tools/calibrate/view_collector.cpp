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
constexpr double least_tilt = 0.08;  // perspective of some 20 degrees at usual distances
constexpr int enough_corners = 6;    // corners in a ninth of the image

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

const char* const tilt_names[tilts] = {"its left side nearer", "its right side nearer", "its top nearer", "its bottom nearer"};

TakenView ViewCollector::described(const BoardView& view) const {
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
  TakenView taken;
  taken.appearance = {middle.x / width, middle.y / height, std::sqrt(area / (width * height)), ratio(cv::norm(d - a), cv::norm(c - b)),
                      ratio(cv::norm(b - a), cv::norm(c - d))};
  taken.outline = {cv::Point2f(a), cv::Point2f(b), cv::Point2f(c), cv::Point2f(d)};
  for (const cv::Point2f& corner : view.corners) {
    const int column = std::clamp(static_cast<int>(3 * corner.x / static_cast<float>(size_.width)), 0, 2);
    const int row = std::clamp(static_cast<int>(3 * corner.y / static_cast<float>(size_.height)), 0, 2);
    ++taken.cells[static_cast<size_t>(3 * row + column)];
  }
  return taken;
}

Look ViewCollector::consider(const BoardView& left, const BoardView& right, bool asked) {
  const double moved = std::max(motion(left, last_[0]), motion(right, last_[1]));
  last_[0] = left;
  last_[1] = right;
  if (left.empty() || right.empty()) return Look::no_board;
  if (!asked && moved > at_rest * size_.width) return Look::moving;
  const TakenView now = described(left);
  for (const auto* all : {&views_, &undone_})
    for (const TakenView& before : *all)
      if (!asked && difference(now.appearance, before.appearance) < another_view) return Look::known;
  views_.push_back(now);
  for (size_t i = 0; i < cells_.size(); ++i) cells_[i] += now.cells[i];
  return Look::taken;
}

void ViewCollector::undo() {
  if (views_.empty()) return;
  for (size_t i = 0; i < cells_.size(); ++i) cells_[i] -= views_.back().cells[i];
  undone_.push_back(views_.back());
  views_.pop_back();
}

bool ViewCollector::covered(size_t cell) const { return cells_[cell] >= enough_corners; }

bool ViewCollector::tilted(size_t tilt) const {
  return std::any_of(views_.begin(), views_.end(), [tilt](const TakenView& view) {
    const double sign = tilt % 2 == 0 ? 1 : -1;
    return sign * (tilt < 2 ? view.appearance.across : view.appearance.down) > least_tilt;
  });
}

std::string ViewCollector::missing() const {
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  for (size_t i = 0; i < 9; ++i)
    if (!covered(i)) add(std::string("board ") + (i == 4 ? "in the " : "at the ") + cell_names[i]);
  for (size_t i = 0; i < tilts; ++i)
    if (!tilted(i)) add(tilt_names[i]);
  return text;
}

}  // namespace vdisp::calibrate
