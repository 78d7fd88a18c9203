// drop_offs.cpp: part of `occupancy`: where the ground ends.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr double hole_of_step = 0.75;                     // what is this part of max_height lower than the floor would go on is a drop-off
constexpr double visible_by = 0.09, beside_slope = 0.05;  // rad, m
constexpr int floor_leads = 3;                            // cells: floor no farther than this before a drop-off leads up to it
constexpr int slope_cells = 5;                            // that the ground's slope before a drop-off is taken from
constexpr int hidden_cells = 4, least_hidden = 2;         // of a drop-off: cells looked at, and through which what is lower is seen
constexpr int edge_beside = 2;                            // of a drop-off, in the next column: cells it may be nearer or farther there
constexpr int edge_cells = 2;                             // of a drop-off that are told; what lies behind is hidden
constexpr int beside_lone = 4;                            // cells: as far off is the same edge in the next column
constexpr int most_between = 20, off_line = 2;            // cells: edges that are one, and how straight it is

}  // namespace

void Occupancy::drop_offs(const Inputs& in, Image& occupancy, Image& reason) noexcept {
  std::fill(edges_.begin(), edges_.end(), -1);
  const double cell = config_.map.cell, least = hole_of_step * config_.limit.max_height;
  for (int column = 0; column < columns_; ++column) {
    int last_floor = -1;
    for (int row = rows_ - 1; row >= 0; --row) {
      uint8_t& why = reason.row<uint8_t>(row)[column];
      if (why == static_cast<uint8_t>(CellReason::floor)) last_floor = row;
      const Beyond& seen = beyond_[static_cast<size_t>(row * columns_ + column)];
      if (seen.ahead <= 0 || last_floor < 0 || last_floor - row > floor_leads) continue;
      const double edge = (rows_ - last_floor - 0.5) * cell, here = in.floor.elevation(edge);
      const double slope = std::min((here - in.floor.elevation(edge - slope_cells * cell)) / (slope_cells * cell), 0.0);
      // A slope falls away gradually, as far as it can be seen at all: 5 degrees less steep than the line of sight.
      const double sight = std::atan2(in.pose.height - here, edge),
                   steepest = std::tan(std::min(config_.floor.maxSlope, sight - visible_by));
      const double past = (last_floor - row - 0.5) * cell, tangent = std::tan(sight);
      const double of_slope = steepest > 0 ? past * tangent * steepest / (tangent - steepest) + beside_slope : 0;
      const auto is_deep = [&](int r, int c, double at_least) {
        if (r < 0 || r >= rows_ || c < 0 || c >= columns_) return false;
        const Beyond& through = beyond_[static_cast<size_t>(r * columns_ + c)];
        if (through.wall) return true;
        return through.ahead > 0 &&
               here + slope * (static_cast<double>(through.ahead) - edge) - static_cast<double>(through.height) >= at_least;
      };
      if (!is_deep(row, column, std::max(least, of_slope))) continue;
      // What is lower lies behind a hidden stretch, seen through all the cells there; one false match is seen through one.
      int deep = 0;
      for (int r = row; r > row - hidden_cells; --r) deep += is_deep(r, column, least);
      // An edge is wider than a cell, or the rover need not mind it.
      bool beside = false;
      for (int r = row - edge_beside; r <= row + edge_beside; ++r)
        beside = beside || is_deep(r, column - 1, least) || is_deep(r, column + 1, least);
      if (deep < least_hidden || !beside) continue;
      if (edges_[static_cast<size_t>(column)] < 0) edges_[static_cast<size_t>(column)] = last_floor - 1;
      // The ground ends somewhere between the last floor and what is seen through.
      for (int r = last_floor - 1; r > std::max(row - edge_cells, -1); --r) {
        uint8_t& edge_why = reason.row<uint8_t>(r)[column];
        if (edge_why == static_cast<uint8_t>(CellReason::obstacle)) break;
        occupancy.row<int8_t>(r)[column] = 100;
        edge_why = static_cast<uint8_t>(CellReason::drop_off);
      }
      last_floor = -1;
    }
  }
}

/// Between two parts of an edge that are seen nothing may be matched, neither grazing ground nor what lies lower. Where the floor ends all
/// along the line between them, and is seen nowhere behind it, that is the edge too.
void Occupancy::join_edges(Image& occupancy, Image& reason) const noexcept {
  const auto is = [&](int row, int column, CellReason why) { return reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(why); };
  int before = -1;
  for (int column = 0; column < columns_; ++column) {
    const int here = edges_[static_cast<size_t>(column)];
    if (here < 0) continue;
    const int left = std::exchange(before, column), between = column - left - 1;
    if (left < 0 || between < 1 || between > most_between) continue;
    const int there = edges_[static_cast<size_t>(left)];
    const auto on_line = [&](int c) { return there + (here - there) * (c - left) / (column - left); };
    bool open = false;
    for (int c = left + 1; c < column && !open; ++c) {
      for (int r = std::max(on_line(c) - off_line - hidden_cells, 0); r < on_line(c) - off_line; ++r)
        open = open || is(r, c, CellReason::floor);
    }
    for (int c = left + 1; c < column && !open; ++c) {
      for (int r = std::max(on_line(c) - off_line, 0); r <= std::min(on_line(c) + off_line, rows_ - 2); ++r) {
        if (!is(r + 1, c, CellReason::floor) || occupancy.row<int8_t>(r)[c] >= 0) continue;
        occupancy.row<int8_t>(r)[c] = 100;
        reason.row<uint8_t>(r)[c] = static_cast<uint8_t>(CellReason::drop_off);
        break;
      }
    }
  }
}

/// An edge that is told in one column alone, and in none of the two to each side of it, is a false match: narrower than a wheel, and the
/// rover would stop for it. What is there is unknown.
void Occupancy::refuse_lone_edges(Image& occupancy, Image& reason) const noexcept {
  constexpr auto drop_off = static_cast<uint8_t>(CellReason::drop_off);
  const auto in_column = [&](int row, int column) {
    if (column < 0 || column >= columns_) return false;
    for (int r = std::max(row - beside_lone, 0); r <= std::min(row + beside_lone, rows_ - 1); ++r)
      if (reason.row<uint8_t>(r)[column] == drop_off) return true;
    return false;
  };
  const auto beside = [&](int row, int column) {
    return in_column(row, column - 1) || in_column(row, column + 1) || in_column(row, column - 2) || in_column(row, column + 2);
  };
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      uint8_t& why = reason.row<uint8_t>(row)[column];
      if (why != drop_off || beside(row, column)) continue;
      occupancy.row<int8_t>(row)[column] = -1;
      why = static_cast<uint8_t>(CellReason::rejected);
    }
  }
}

}  // namespace vdisp
