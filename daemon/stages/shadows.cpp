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
  const auto stands = [&](int row, int column) {
    return occupancy.row<int8_t>(row)[column] >= occupied_from && is(row, column, CellReason::obstacle);
  };
  // From the rover on: where nothing stands in the rows that throw a shadow on a row there is none to look for.
  int last_standing = rows_;
  for (int row = rows_ - 1; row >= 0; --row) {
    const double ahead = rows_ - row - 0.5;
    const int steps = static_cast<int>(std::ceil(reach * ahead));
    for (int column = 0; last_standing <= row + steps && column < columns_; ++column) {
      if (!is(row, column, CellReason::floor)) continue;
      const double across = column + 0.5 - columns_ / 2.0;
      for (int step = 1; step <= steps && row + step < rows_; ++step) {
        const int c = static_cast<int>(across * (1 - step / ahead) + columns_ / 2.0);
        if (!stands(row + step, c)) continue;
        occupancy.row<int8_t>(row)[column] = -1;
        reason.row<uint8_t>(row)[column] = static_cast<uint8_t>(CellReason::occluded);
        break;
      }
    }
    for (int column = 0; last_standing > row && column < columns_; ++column)
      if (stands(row, column)) last_standing = row;
  }
}

}  // namespace vdisp
