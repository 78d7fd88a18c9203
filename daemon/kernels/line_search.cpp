// line_search.cpp: the plain forms of listing points and of asking which lie near a line.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/line_search.h"

#include <cmath>

namespace vdisp::kernels::plain {

size_t collect_points(Plane<const int16_t> votes, int threshold, const Points& points) {
  size_t n = 0;
  for (int v = 0; v < votes.height; ++v) {
    const int16_t* row = votes.row(v);
    for (int column = 0; column < votes.width; ++column) {
      if (row[column] <= threshold) continue;
      points.column[n] = static_cast<float>(column);
      points.row[n] = static_cast<float>(v);
      points.votes[n++] = row[column];
    }
  }
  return n;
}

size_t count_near(const Points& points, size_t n, float slope, float row0, float reach, size_t beat) {
  uint32_t count = 0;
  for (size_t i = 0; i < n; ++i) count += std::abs(slope * points.column[i] + row0 - points.row[i]) < reach;
  return count > beat ? count : 0;
}

NearSums sum_near(const Points& points, size_t n, double slope, double row0, double reach) {
  NearSums sums{};
  for (size_t i = 0; i < n; ++i) {
    const double column = points.column[i], row = points.row[i], votes = points.votes[i];
    sums.all += votes;
    if (std::abs(slope * column + row0 - row) >= reach) continue;
    ++sums.count;
    sums.votes += votes;
    sums.column += votes * column;
    sums.row += votes * row;
    sums.column_column += votes * column * column;
    sums.column_row += votes * column * row;
  }
  return sums;
}

}  // namespace vdisp::kernels::plain
