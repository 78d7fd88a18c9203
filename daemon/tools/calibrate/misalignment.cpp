// misalignment.cpp: five numbers by weighted least squares.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/misalignment.h"

#include <algorithm>
#include <cmath>

namespace vdisp::calibrate {
namespace {

constexpr int rounds = 15;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

using Numbers = cv::Vec<double, 5>;

/// What a shift, roll, size, yaw and the bend of a rotation about x move rows by. The bend has no name: without it, it would pass for size.
Numbers basis(const RowMatch& match, const StereoView& view) {
  const double x = (match.right.x - view.cx + view.cx_offset) / view.f, y = (match.right.y - view.cy) / view.f;
  return {1, x, y, x * y, y * y};
}

}  // namespace

Misalignment fit_misalignment(const std::vector<RowMatch>& matches, const StereoView& view) {
  Misalignment result;
  result.matches = matches.size();
  std::vector<double> rows;
  for (const RowMatch& match : matches) rows.push_back(match.rows());
  Numbers found(median(rows), 0, 0, 0, 0);
  std::vector<double> left(rows.size());
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < rows.size(); ++i) left[i] = std::abs(rows[i] - basis(matches[i], view).dot(found));
    const double width = std::max(4.7 * 1.4826 * median(left), 0.2);  // Tukey's, px
    cv::Matx<double, 5, 5> normal = cv::Matx<double, 5, 5>::zeros();
    Numbers right;
    for (size_t i = 0; i < rows.size(); ++i) {
      if (left[i] >= width) continue;
      const double weight = std::pow(1 - std::pow(left[i] / width, 2), 2);
      const Numbers b = basis(matches[i], view);
      normal += weight * b * b.t();
      right += weight * rows[i] * b;
    }
    for (int i = 0; i < 5; ++i) normal(i, i) += 1e-9;
    found = normal.inv(cv::DECOMP_CHOLESKY) * right;
  }
  for (size_t i = 0; i < rows.size(); ++i) left[i] = std::abs(rows[i] - basis(matches[i], view).dot(found));
  for (double& row : rows) row = std::abs(row);
  result.median_px = median(rows);
  result.remaining_px = median(left);
  result.shift_px = found[0];
  result.roll_rad = found[1] / view.f;
  result.scale = found[2] / view.f;
  result.yaw_rad = found[3] / view.f;
  return result;
}

}  // namespace vdisp::calibrate
