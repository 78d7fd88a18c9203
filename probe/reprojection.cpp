// reprojection.cpp: paper equations 2 and 3 with the measured pitch and roll.
// SPDX-License-Identifier: Apache-2.0
#include "probe/reprojection.h"

#include <algorithm>
#include <cmath>

#include "probe/readout.h"

namespace vdisp {

Reprojection::Reprojection(const Image& disparity, const FloorModel& floor, const Image& grid)
    : disparity_(disparity),
      grid_(grid),
      floor_(floor),
      f_(disparity.camera.f),
      cx_(disparity.camera.cx),
      cy_(disparity.camera.cy),
      baseline_(disparity.camera.baseline),
      offset_(disparity.camera.cx_offset),
      cell_(std::round(1e6 * static_cast<double>(grid.grid.cell)) / 1e6),  // 0.1, not the float nearest to it: borders are the daemon's
      origin_row_(grid.grid.origin_row),
      origin_column_(grid.grid.origin_column) {
  const double roll = std::isfinite(floor.roll_rad) ? floor.roll_rad : 0;
  cos_pitch_ = std::cos(floor.pitch_rad);
  sin_pitch_ = std::sin(floor.pitch_rad);
  cos_roll_ = std::cos(roll);
  sin_roll_ = std::sin(roll);
  possible_ = f_ > 0 && baseline_ > 0 && std::isfinite(f_ * baseline_ + cx_ + cy_ + offset_) && usable(grid.grid) && cell_ > 0 &&
              floor.state != FloorState::lost && std::isfinite(floor.pitch_rad) && floor.height_m > 0 && std::isfinite(floor.height_m);
}

std::optional<double> Reprojection::depth(double disparity) const {
  if (!(disparity > offset_)) return {};
  return f_ * baseline_ / (disparity - offset_);
}

std::optional<MapCell> Reprojection::cell_of(int column, int row, double disparity) const {
  const auto z = depth(disparity);
  if (!z) return {};
  const double x = (column - cx_) * *z / f_, y = (row - cy_) * *z / f_;
  const double across = x * cos_roll_ - y * sin_roll_, down = x * sin_roll_ + y * cos_roll_;
  const double ahead = *z * cos_pitch_ - down * sin_pitch_;
  const double r = origin_row_ - 1 - std::floor(ahead / cell_), c = std::floor(across / cell_ + origin_column_);
  if (!(r >= 0 && r < grid_.spec.height && c >= 0 && c < grid_.spec.width)) return {};
  return MapCell{static_cast<int>(r), static_cast<int>(c)};
}

std::optional<double> Reprojection::floor_disparity(int column, int row) const {
  // d' = B / H n.(u - cx, v - cy, f), n being straight down in the camera's frame.
  const double down = sin_roll_ * cos_pitch_ * (column - cx_) + cos_roll_ * cos_pitch_ * (row - cy_) + sin_pitch_ * f_;
  if (!(down > 0)) return {};
  return baseline_ / floor_.height_m * down + offset_;
}

double Reprojection::elevation(double ahead) const {
  const uint32_t count = std::min(floor_.profile_count, FloorModel::profile_capacity);
  const double step = floor_.profile_step_m;
  if (count == 0 || !(step > 0)) return 0;
  const double at = std::clamp((ahead - static_cast<double>(floor_.profile_start_m)) / step, 0.0, count - 1.0);
  if (!(at >= 0)) return 0;  // NaN
  const auto i = static_cast<uint32_t>(at);
  const double low = floor_.profile_m[i], high = floor_.profile_m[std::min(i + 1, count - 1)];
  return low + (at - i) * (high - low);
}

Reprojection::Seen Reprojection::see(double x, double ahead) const {
  const double down = floor_.height_m - elevation(ahead);
  const double y = down * cos_pitch_ - ahead * sin_pitch_, z = down * sin_pitch_ + ahead * cos_pitch_;
  const double nearest = std::max(z, 0.05);  // what lies beside or behind the camera is below every picture
  return {cx_ + f_ * (x * cos_roll_ + y * sin_roll_) / nearest, cy_ + f_ * (y * cos_roll_ - x * sin_roll_) / nearest, nearest};
}

CellView Reprojection::view_of(const MapCell& cell) const {
  const double near = (origin_row_ - 1 - cell.row) * cell_, x = (cell.column - origin_column_) * cell_;
  const Seen a = see(x, near), b = see(x + cell_, near + cell_);
  const double middle = (a.u + b.u) / 2, half = f_ * cell_ / (a.z + b.z);
  const auto pixel = [](double at, int size) {
    return std::isfinite(at) ? static_cast<int>(std::clamp<double>(std::round(at), 0, size)) : 0;
  };
  const int width = disparity_.spec.width, height = disparity_.spec.height;
  return {pixel(middle - half, width),       pixel(middle + half, width),    pixel(std::min(a.v, b.v), height),
          pixel(std::max(a.v, b.v), height), f_ * baseline_ / b.z + offset_, f_ * baseline_ / a.z + offset_};
}

}  // namespace vdisp
