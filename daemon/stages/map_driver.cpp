// map_driver.cpp: cells into the rover frame; the first of each corridor that is not free.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map_driver.h"

#include <algorithm>
#include <cmath>

namespace vdisp {
namespace {

constexpr double least_zone = 0.3;  // m from the nearest cell in view, in which the ground must be known
constexpr double most_unknown = 1.0 / 3;
constexpr double step_rad = 0.0873, most_rad = 1.05;  // 5 degrees up to 60

/// The camera looks there.
bool in_sight(uint8_t reason) {
  const auto why = static_cast<CellReason>(reason);
  return why != CellReason::out_of_view && why != CellReason::too_near && why != CellReason::overhang;
}

/// Why an unknown cell is suspected.
bool stands(uint8_t reason) {
  const auto why = static_cast<CellReason>(reason);
  return why == CellReason::obstacle || why == CellReason::drop_off;
}

}  // namespace

void MapDriver::prepare(const ImageSpec& grid) {
  const size_t cells = static_cast<size_t>(grid.width) * grid.height;
  obstacles_.reserve(cells);
  ground_.reserve(cells);
}

void MapDriver::collect(const Image& grid, const Image* reason) noexcept {
  obstacles_.clear();
  ground_.clear();
  const GridGeometry& g = grid.grid;
  const float cosine = std::cos(g.pose_yaw), sine = std::sin(g.pose_yaw), half = static_cast<float>(half_width());
  const float far = static_cast<float>(config_.decide.far), far2 = far * far;
  for (int row = 0; row < grid.spec.height; ++row) {
    const float along = (g.origin_row - static_cast<float>(row) - 0.5f) * g.cell;
    const uint8_t* why = reason ? reason->row<uint8_t>(row) : nullptr;
    for (int column = 0; column < grid.spec.width; ++column) {
      const bool counts = grid.spec.pixel == Pixel::count16;
      const int value = counts ? grid.row<int16_t>(row)[column] : grid.row<int8_t>(row)[column];
      const bool obstacle = counts ? value >= static_cast<int>(g.min_count) : value >= occupied_from;
      if (!obstacle && (!why || !in_sight(why[column]))) continue;
      const float across = (g.origin_column - static_cast<float>(column) - 0.5f) * g.cell;  // to the left
      const bool suspected = !obstacle && (value > free_up_to || (value < 0 && stands(why[column])));
      const Cell cell{g.pose_x + along * cosine - across * sine, g.pose_y + along * sine + across * cosine, suspected, value < 0};
      if (cell.ahead <= 0 || cell.ahead * cell.ahead + cell.left * cell.left > far2) continue;
      if (obstacle || suspected) {
        obstacles_.push_back(cell);
      } else if (std::abs(cell.left) < half) {
        ground_.push_back(cell);
      }
    }
  }
}

/// Along the corridor in the direction `turned`, rad to the left; far where there is none. What is suspected counts up to `suspected_to`.
double MapDriver::first_obstacle(double turned, double suspected_to) const noexcept {
  const double cosine = std::cos(turned), sine = std::sin(turned), half = half_width();
  double first = config_.decide.far;
  for (const Cell& cell : obstacles_) {
    const double x = static_cast<double>(cell.ahead), y = static_cast<double>(cell.left);
    const double ahead = x * cosine + y * sine, left = y * cosine - x * sine;
    if (cell.suspected && ahead > suspected_to) continue;
    if (ahead > 0 && std::abs(left) < half) first = std::min(first, ahead);
  }
  return first;
}

/// The nearest cell in view of the corridor, m ahead.
double MapDriver::nearest() const noexcept {
  double nearest = config_.decide.far;
  const double half = half_width();
  for (const auto* cells : {&ground_, &obstacles_}) {
    for (const Cell& cell : *cells)
      if (std::abs(static_cast<double>(cell.left)) < half) nearest = std::min(nearest, static_cast<double>(cell.ahead));
  }
  return nearest;
}

/// Where the ground up to `zone` is unknown; far where it is known well enough. What stands or may stand there is told by
/// first_obstacle().
double MapDriver::first_unknown(double zone) const noexcept {
  const double near = config_.decide.near, far = config_.decide.far;
  double first = far;
  int all = 0, unknown = 0;
  for (const Cell& cell : ground_) {
    if (static_cast<double>(cell.ahead) > zone) continue;
    ++all;
    if (!cell.unknown) continue;
    ++unknown;
    first = std::min(first, static_cast<double>(cell.ahead));
  }
  if (all == 0) return first_obstacle(0, zone) < far ? far : 0;
  return unknown > most_unknown * all ? std::min(first, near) : far;
}

bool MapDriver::evade_left(double end) const noexcept {
  double left = 0, right = 0;
  for (double turned = step_rad; turned <= most_rad; turned += step_rad) {
    const double to_left = first_obstacle(turned, end), to_right = first_obstacle(-turned, end);
    const bool free_left = to_left >= end, free_right = to_right >= end;
    if (free_left != free_right) return free_left;
    left += to_left;
    right += to_right;
    if (free_left && to_left != to_right) return to_left > to_right;
  }
  return left >= right;
}

MapWay MapDriver::look(const Image& grid, const Image* reason) noexcept {
  collect(grid, reason);
  MapWay way;
  const double near = config_.decide.near, far = config_.decide.far, seen_from = reason ? nearest() : 0;
  // What stands where the view begins beyond near would be out of view before it is near.
  const double zone = std::min(std::max(near, seen_from + least_zone), far), end = seen_from > near ? zone : near;
  way.corridor_m = std::min(first_obstacle(0, end), reason ? first_unknown(zone) : far);
  // What is unknown up to near is not free, also where its first cell is the last.
  way.free = way.corridor_m > end || way.corridor_m >= far;
  way.clearness = std::clamp((std::min(way.corridor_m, first_obstacle(0, far)) - near) / (far - near), 0.0, 1.0);
  way.left = way.free || evade_left(end);
  return way;
}

}  // namespace vdisp
