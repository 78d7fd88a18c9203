// roc.cpp: examples in the order of their scores.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/roc.h"

#include <algorithm>
#include <limits>

namespace vdisp::snow {
namespace {

std::vector<Judged> sorted(std::span<const Judged> judged) {
  std::vector<Judged> all(judged.begin(), judged.end());
  std::sort(all.begin(), all.end(), [](const Judged& a, const Judged& b) { return a.score > b.score; });
  return all;
}

double rate(size_t part, size_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

}  // namespace

double Confusion::accuracy() const {
  const size_t all = positives() + negatives();
  return all ? rate(hits + rejections, all) : 0;
}

Confusion confusion(std::span<const Judged> judged, double threshold) {
  Confusion found;
  for (const Judged& one : judged) {
    const bool taken = one.score >= threshold;
    ++(one.positive ? (taken ? found.hits : found.misses) : (taken ? found.false_alarms : found.rejections));
  }
  return found;
}

std::vector<RocPoint> roc_curve(std::span<const Judged> judged) {
  const auto all = sorted(judged);
  const size_t positives = static_cast<size_t>(std::count_if(all.begin(), all.end(), [](const Judged& one) { return one.positive; }));
  const size_t negatives = all.size() - positives;
  if (!positives || !negatives) return {};
  std::vector<RocPoint> curve{{std::numeric_limits<double>::infinity(), 0, 0}};
  size_t hits = 0, alarms = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    ++(all[i].positive ? hits : alarms);
    if (i + 1 == all.size() || all[i + 1].score != all[i].score)
      curve.push_back({all[i].score, rate(alarms, negatives), rate(hits, positives)});
  }
  return curve;
}

double area_under_curve(std::span<const Judged> judged) {
  const auto all = sorted(judged);
  double above = 0;  // pairs with the positive before the negative
  size_t positives = 0;
  for (size_t i = 0; i < all.size();) {
    size_t equal[2] = {}, end = i;
    for (; end < all.size() && all[end].score == all[i].score; ++end) ++equal[all[end].positive];
    above += static_cast<double>(equal[0]) * (static_cast<double>(positives) + 0.5 * static_cast<double>(equal[1]));
    positives += equal[1];
    i = end;
  }
  const size_t negatives = all.size() - positives;
  if (!positives || !negatives) return std::numeric_limits<double>::quiet_NaN();
  return above / (static_cast<double>(positives) * static_cast<double>(negatives));
}

RocPoint point_of_detection(std::span<const RocPoint> curve, double true_rate) {
  return *std::find_if(curve.begin() + 1, curve.end() - 1, [true_rate](const RocPoint& point) { return point.true_rate >= true_rate; });
}

RocPoint best_point(std::span<const RocPoint> curve) {
  return *std::max_element(curve.begin() + 1, curve.end(),
                           [](const RocPoint& a, const RocPoint& b) { return a.true_rate - a.false_rate < b.true_rate - b.false_rate; });
}

}  // namespace vdisp::snow
