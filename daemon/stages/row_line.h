// row_line.h: part of `row_error`: row errors of the last seconds, and the line over the image that they lie on.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdisp {

/// Where a row error was measured, px from the middle of the image, and how large it was (px, lower in the right view).
struct RowPoint {
  float x, y, rows;
  int64_t timestamp_ns;
};

/// rows = shift + rotation x + (something) y. What rows say of how the cameras stand is told apart by where in the image they differ:
/// by a shift everywhere alike, by a rotation about the view in proportion to x. The third takes up what another f would do.
struct RowLine {
  int points = 0;
  double median = 0, p90 = 0;                          ///< of |rows|, px
  double shift = 0, rotation = 0;                      ///< px, rad
  double shift_deviation = 0, rotation_deviation = 0;  ///< standard deviations by what is left over
};

/// The newest points, as many as fit. Fixed memory; nothing here allocates.
class RowPoints {
 public:
  static constexpr int capacity = 768;
  void add(const RowPoint& point) noexcept;
  /// Those older than this are gone. Time that runs backwards empties it: another recording has begun.
  void forget_before(int64_t timestamp_ns) noexcept;
  void clear() noexcept { first_ = count_ = 0; }
  int count() const noexcept { return count_; }
  int64_t oldest_ns() const noexcept { return count_ ? at(0).timestamp_ns : 0; }
  int64_t newest_ns() const noexcept { return count_ ? at(count_ - 1).timestamp_ns : 0; }
  /// Least squares with Tukey's weights. At least 20 points.
  RowLine fit() noexcept;

 private:
  const RowPoint& at(int i) const noexcept { return ring_[static_cast<size_t>((first_ + i) % capacity)]; }
  float ranked(int percent) noexcept;

  std::array<RowPoint, capacity> ring_{};
  std::array<float, capacity> scratch_{};
  int first_ = 0, count_ = 0;
};

}  // namespace vdisp
