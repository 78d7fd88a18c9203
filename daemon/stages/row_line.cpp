// row_line.cpp: a plane over x and y by reweighted least squares: three numbers, a handful of rounds.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/row_line.h"

#include <algorithm>
#include <cmath>

namespace vdisp {
namespace {

constexpr int rounds = 6;
constexpr double gauss = 1.4826, tukey = 4.7, least_width = 0.2;  // px: noise of good matches
constexpr double weighted_loss = 1.05;                            // Tukey's weights know a little less than plain means (95 %)

struct Normal {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, r = 0, xr = 0, yr = 0;

  void add(const RowPoint& p, double weight) {
    const double px = p.x, py = p.y, rows = p.rows;
    n += weight, x += weight * px, y += weight * py, r += weight * rows;
    xx += weight * px * px, xy += weight * px * py, yy += weight * py * py;
    xr += weight * px * rows, yr += weight * py * rows;
  }
};

struct Plane {
  double shift = 0, across = 0, down = 0;
  double var_shift = 0, var_across = 0;  // of noise 1
  double left_over(const RowPoint& p) const {
    return static_cast<double>(p.rows) - shift - across * static_cast<double>(p.x) - down * static_cast<double>(p.y);
  }
};

/// The inverse of a symmetric 3x3 matrix by its minors. A ridge of one pixel keeps points that lie on one spot or line from dividing by 0.
Plane solve(Normal s) {
  s.xx += 1, s.yy += 1, s.n += 1e-6;
  const double a = s.xx * s.yy - s.xy * s.xy, b = s.xy * s.y - s.x * s.yy, c = s.x * s.xy - s.xx * s.y;
  const double determinant = s.n * a + s.x * b + s.y * c;
  const double d = s.n * s.yy - s.y * s.y, e = s.x * s.y - s.n * s.xy, f = s.n * s.xx - s.x * s.x;
  return {(a * s.r + b * s.xr + c * s.yr) / determinant, (b * s.r + d * s.xr + e * s.yr) / determinant,
          (c * s.r + e * s.xr + f * s.yr) / determinant, a / determinant, d / determinant};
}

}  // namespace

void RowPoints::add(const RowPoint& point) noexcept {
  if (count_ > 0 && point.timestamp_ns < newest_ns()) clear();
  if (count_ == capacity) first_ = (first_ + 1) % capacity, --count_;
  ring_[static_cast<size_t>((first_ + count_) % capacity)] = point;
  ++count_;
}

void RowPoints::forget_before(int64_t timestamp_ns) noexcept {
  while (count_ > 0 && at(0).timestamp_ns < timestamp_ns) first_ = (first_ + 1) % capacity, --count_;
}

/// Of what is in scratch_, reordered.
float RowPoints::ranked(int percent) noexcept {
  const auto middle = scratch_.begin() + (count_ - 1) * percent / 100;
  std::nth_element(scratch_.begin(), middle, scratch_.begin() + count_);
  return *middle;
}

RowLine RowPoints::fit() noexcept {
  RowLine line;
  line.points = count_;
  for (int i = 0; i < count_; ++i) scratch_[static_cast<size_t>(i)] = at(i).rows;
  Plane plane;
  plane.shift = ranked(50);
  double width = 0, noise = 0;
  for (int round = 0; round < rounds; ++round) {
    for (int i = 0; i < count_; ++i) scratch_[static_cast<size_t>(i)] = static_cast<float>(std::abs(plane.left_over(at(i))));
    noise = gauss * static_cast<double>(ranked(50));
    width = std::max(tukey * noise, least_width);
    Normal sums;
    for (int i = 0; i < count_; ++i) {
      const double off = plane.left_over(at(i)) / width;
      if (std::abs(off) < 1) sums.add(at(i), (1 - off * off) * (1 - off * off));
    }
    plane = solve(sums);
  }
  noise = std::max(noise, least_width / tukey);
  for (int i = 0; i < count_; ++i) scratch_[static_cast<size_t>(i)] = std::abs(at(i).rows);
  line.median = static_cast<double>(ranked(50));
  line.p90 = static_cast<double>(ranked(90));
  line.shift = plane.shift;
  line.rotation = plane.across;
  line.shift_deviation = weighted_loss * noise * std::sqrt(plane.var_shift);
  line.rotation_deviation = weighted_loss * noise * std::sqrt(plane.var_across);
  return line;
}

}  // namespace vdisp
