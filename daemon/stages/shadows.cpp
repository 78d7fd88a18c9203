// shadows.cpp: part of `occupancy`: no floor is seen in the shadow of an obstacle; what hides no floor is likely to be false.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr int least_hidden = 2;   // cells, of which most show floor
constexpr int beside_shadow = 1;  // cells: half a window of the matcher, and the strip that one camera sees alone

double shadow(const Config& config, double camera_height) { return std::min(config.limit.max_height / camera_height, 0.9); }

}  // namespace

/// The column, `step` rows nearer, of the cell through which the camera looks at this one.
int Occupancy::column_on_ray(int row, int column, int step) const noexcept {
  return static_cast<int>(std::floor((column + 0.5 - columns_ / 2.0) * (1 - step / (rows_ - row - 0.5)) + columns_ / 2.0));
}

/// Whether an obstacle stands nearer on the way to a cell, or beside that way.
bool Occupancy::is_hidden(int row, int column) const noexcept {
  for (int step = 1; row + step < rows_; ++step) {
    const int c = column_on_ray(row, column, step);
    for (int beside = std::max(c - beside_shadow, 0); beside <= std::min(c + beside_shadow, columns_ - 1); ++beside)
      if (standing_[static_cast<size_t>((row + step) * columns_ + beside)]) return true;
  }
  return false;
}

/// Whether hardly anything but floor is seen in most cells that what stands in this one would hide, if it were no higher than max_height:
/// those far enough behind for its own foot not to look like their floor. It hangs in the air then, or is a false match; a narrow post
/// hides a part of each.
bool Occupancy::hides_no_floor(const Inputs& in, int cell, const Image& reason) const noexcept {
  const double reach = shadow(config_, in.pose.height);
  const int row = cell / columns_, column = cell % columns_;
  const double ahead = rows_ - row - 0.5, own = box(in, row, column).d_far;
  int hidden = 0, floor = 0;
  for (int r = row - 1; r >= 0 && (rows_ - r - 0.5) * (1 - reach) <= ahead; --r) {
    const int c = column_on_ray(row, column, r - row);
    if (c < 0 || c >= columns_) break;
    if ((1 + depth_share) * box(in, r, c).d_near + depth_off > own) continue;
    ++hidden;
    floor += reason.row<uint8_t>(r)[c] == static_cast<uint8_t>(CellReason::floor) && whole_[static_cast<size_t>(r * columns_ + c)];
  }
  return hidden >= least_hidden && 2 * floor > hidden;
}

/// What looks like floor close behind an obstacle is its foot. What was doubted hides as much.
void Occupancy::shade(const Inputs& in, Image& occupancy, Image& reason) const noexcept {
  const double reach = shadow(config_, in.pose.height);
  const auto is = [&](int row, int column, CellReason why) { return reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(why); };
  const auto stands = [&](int row, int column) { return standing_[static_cast<size_t>(row * columns_ + column)] != 0; };
  // From the rover on: where nothing stands in the rows that throw a shadow on a row there is none to look for.
  int last_standing = rows_;
  for (int row = rows_ - 1; row >= 0; --row) {
    const double ahead = rows_ - row - 0.5;
    const int steps = static_cast<int>(std::ceil(reach * ahead));
    for (int column = 0; last_standing <= row + steps && column < columns_; ++column) {
      if (!is(row, column, CellReason::floor)) continue;
      for (int step = 1; step <= steps && row + step < rows_; ++step) {
        if (!stands(row + step, column_on_ray(row, column, step))) continue;
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
