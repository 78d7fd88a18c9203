// ground_rows.h: where pixels stand on the ground, in single precision, and how far off that can be from the exact place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "daemon/kernels/map.h"

namespace vdisp::kernels {

/// In single precision, and in cells, a pixel stands Z (keep - drop[u]) ahead and Z (across[u] - shift) to the right of the camera,
/// with Z by its disparity, drop and across by its column, keep and shift by its row.
class GroundRows {
 public:
  GroundRows(const Ground& ground, const Search& search, int width, GroundScratch& scratch) : ground_(ground) {
    scale_ = ground.f * ground.baseline / ground.cell;
    by_f_ = 1 / ground.f;
    per_row_ = 16 * scale_ / (ground.rows + 1);
    for (int column = std::max(search.least - search.first, 0); column < search.columns; ++column)
      scratch.depth[static_cast<size_t>(column)] = static_cast<float>(scale_ / ((search.first + column) / 16.0 - ground.cx_offset));
    for (int u = 0; u < width; ++u) {
      const double x = (u - ground.cx) * by_f_;
      scratch.across[static_cast<size_t>(u)] = static_cast<float>(x * ground.cos_roll);
      scratch.drop[static_cast<size_t>(u)] = static_cast<float>(x * ground.sin_roll * ground.sin_pitch);
    }
    const double left = -ground.cx / ground.f, right = (width - 1 - ground.cx) / ground.f, tilt = ground.sin_roll * ground.sin_pitch;
    most_drop_ = std::max(left * tilt, right * tilt);
    widest_ = std::max(std::abs(left), std::abs(right));
    middle = static_cast<float>(ground.columns / 2.0 - 0.5);
    allowed = static_cast<float>(0.5 - 0x1p-22 * (std::max(ground.rows, ground.columns) + 2));
  }
  void go_to(int v) {
    const double y = (v - ground_.cy) * by_f_, exact_keep = ground_.cos_pitch - y * ground_.cos_roll * ground_.sin_pitch;
    const double exact_shift = y * ground_.sin_roll;
    keep = static_cast<float>(exact_keep);
    shift = static_cast<float>(exact_shift);
    // Z, keep and drop are each rounded by 2^-24 of themselves, as are their difference and their product: in all 2^-22 of
    // Z (|keep| + |drop|) at most, and the same for the other axis. Twice that is allowed for.
    less_by_depth = static_cast<float>(0x1p-21 * std::max(std::abs(exact_keep) + widest_, widest_ + std::abs(exact_shift)));
    // What is more than a cell too far off everywhere in the row need not be looked at.
    const double least = per_row_ * (exact_keep - most_drop_) + 16 * ground_.cx_offset;
    nearest = static_cast<int>(std::clamp(least, -32000.0, 32000.0)) - 1;
  }

  float keep = 0, shift = 0;
  float middle;
  float allowed, less_by_depth = 0;  ///< what is within allowed - Z less_by_depth of the middle of a cell is in it for cell_of() too
  int nearest = 0;                   ///< lower disparities are beyond the grid

 private:
  const Ground& ground_;
  double scale_, by_f_, per_row_, most_drop_, widest_;
};

}  // namespace vdisp::kernels
