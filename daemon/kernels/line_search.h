// line_search.h: contracts: the points of the v-disparity, and which of them lie near a line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Points as three lists. A list that holds n points has room for point_room(n), and there are numbers in all of it (kernels read
/// and write whole vectors; what stands behind the points is never part of a result).
/// They are fastest where they are Aligned.
struct Points {
  float *column, *row, *votes;
};
constexpr size_t point_room(size_t points) { return points + 64; }

/// Lists the cells with more than `threshold` (0 .. 32766) votes, row by row from the left; returns how many. Each list has room for all
/// cells.
using CollectPoints = size_t(Plane<const int16_t> votes, int threshold, const Points& points);

/// How many of the first `n` points have |slope column + row0 - row| < reach, in single precision; 0 if no more than `beat`, so that
/// a search for the best line may give up early.
using CountNear = size_t(const Points& points, size_t n, float slope, float row0, float reach, size_t beat);

/// Sums over points; `all`: of the votes of all `n` points, the others of those with |slope column + row0 - row| < reach, in double
/// precision, each point weighed with its votes. All are whole numbers, and exact while below 2^53: they are for images of up to
/// 8192 x 8192 with 4096 columns of disparities.
struct NearSums {
  double count, all, votes, column, row, column_column, column_row;
  bool operator==(const NearSums&) const = default;
};
using SumNear = NearSums(const Points& points, size_t n, double slope, double row0, double reach);

namespace plain {
CollectPoints collect_points;
CountNear count_near;
SumNear sum_near;
}  // namespace plain

}  // namespace vdisp::kernels
