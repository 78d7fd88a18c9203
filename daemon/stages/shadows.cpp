// shadows.cpp: part of `occupancy`: no floor is seen in the shadow of an obstacle.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/stages/occupancy.h"

namespace vdisp {

/// What looks like floor close behind an obstacle is its foot.
void Occupancy::shade(const Inputs& in, Image& occupancy, Image& reason) const noexcept {
  const double reach = std::min(config_.limit.max_height / in.pose.height, 0.9);
  const auto is = [&](int row, int column, CellReason why) { return reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(why); };
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      if (!is(row, column, CellReason::floor)) continue;
      const double ahead = rows_ - row - 0.5, across = column + 0.5 - columns_ / 2.0;
      const int steps = static_cast<int>(std::ceil(reach * ahead));
      for (int step = 1; step <= steps; ++step) {
        const double part = 1 - step / ahead;
        const int r = rows_ - 1 - static_cast<int>(std::floor(ahead - step)),
                  c = static_cast<int>(std::floor(across * part + columns_ / 2.0));
        if (r >= rows_ || c < 0 || c >= columns_) break;
        if (occupancy.row<int8_t>(r)[c] < occupied_from || !is(r, c, CellReason::obstacle)) continue;
        occupancy.row<int8_t>(row)[column] = -1;
        reason.row<uint8_t>(row)[column] = static_cast<uint8_t>(CellReason::occluded);
        break;
      }
    }
  }
}

}  // namespace vdisp
