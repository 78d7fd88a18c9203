// roc.h: how well a score separates two classes: confusion, ROC curve and the area under it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vdisp::snow {

/// A judged example: the higher the score, the more it is taken for a positive.
struct Judged {
  double score;
  bool positive;
};

/// With every score >= threshold taken for a positive. Figure 12: x = false_rate (false acceptance), y = true_rate (detection).
struct RocPoint {
  double threshold, false_rate, true_rate;
};

struct Confusion {
  size_t hits = 0, misses = 0;              ///< positives: taken for one, and not
  size_t false_alarms = 0, rejections = 0;  ///< negatives: taken for a positive, and not
  size_t positives() const { return hits + misses; }
  size_t negatives() const { return false_alarms + rejections; }
  /// Part of all that is judged right; 0 where there is none.
  double accuracy() const;
};

/// A positive where score >= threshold.
Confusion confusion(std::span<const Judged> judged, double threshold);

/// From (0, 0), threshold infinity, to (1, 1): a point for each score that occurs; equal scores are one step, both ways at once.
/// Empty where a class is missing.
std::vector<RocPoint> roc_curve(std::span<const Judged> judged);

/// Chance that a positive has the higher score of two, one of each class; equal scores count half. NaN where a class is missing.
double area_under_curve(std::span<const Judged> judged);

/// The highest threshold of the curve at which at least this part of the positives is found; never the infinite one, with which nothing
/// would ever be a positive. The curve is not empty.
RocPoint point_of_detection(std::span<const RocPoint> curve, double true_rate);
/// The point farthest above the diagonal, never that of the infinite threshold. The curve is not empty.
RocPoint best_point(std::span<const RocPoint> curve);

}  // namespace vdisp::snow
