// shadows.cpp: part of `occupancy`: no floor is seen in the shadow of an obstacle; nor does stand what floor is seen behind.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr int least_hidden = 2;             // cells, of which most show floor
constexpr int shading = occupied_from - 1;  // percent: what was doubted hides as much

double shadow(const Config& config, double camera_height) { return std::min(config.limit.max_height / camera_height, 0.9); }

}  // namespace

/// Whether floor is seen in most cells that what stands in this one would hide, if it is no higher than max_height: those far enough behind
/// for its own foot not to look like their floor.
bool Occupancy::is_seen_under(const Inputs& in, int cell, const Image& reason) const noexcept {
  const double reach = shadow(config_, in.pose.height);
  const int row = cell / columns_, column = cell % columns_;
  const double ahead = rows_ - row - 0.5, across = column + 0.5 - columns_ / 2.0, own = box(in, row, column).d_far;
  int hidden = 0, floor = 0;
  for (int r = row - 1; r >= 0 && (rows_ - r - 0.5) * (1 - reach) <= ahead; --r) {
    const int c = static_cast<int>(std::floor(across * (rows_ - r - 0.5) / ahead + columns_ / 2.0));
    if (c < 0 || c >= columns_) break;
    if ((1 + depth_share) * box(in, r, c).d_near + depth_off > own) continue;
    ++hidden;
    floor += reason.row<uint8_t>(r)[c] == static_cast<uint8_t>(CellReason::floor);
  }
  return hidden >= least_hidden && 2 * floor > hidden;
}

/// What looks like floor close behind an obstacle is its foot.
void Occupancy::shade(const Inputs& in, Image& occupancy, Image& reason) const noexcept {
  const double reach = shadow(config_, in.pose.height);
  const auto is = [&](int row, int column, CellReason why) { return reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(why); };
  const auto stands = [&](int row, int column) {
    return occupancy.row<int8_t>(row)[column] >= shading && is(row, column, CellReason::obstacle);
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
