// navigation.cpp: the queue of cells that are not what they have to be, the cost of one cell, and the descent.
// SPDX-License-Identifier: Apache-2.0
#include "navigation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace planner {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr std::array<Cell, 4> sides{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
constexpr double step = 0.5;  // of the descent, cells

/// The cost T where crossing the cell takes `cost` and the cheaper neighbours of the two axes cost `a` and `c`: the root of
/// (T - a)^2 + (T - c)^2 = cost^2, or a + cost where c lies so high that nothing comes from there. Written so that T is above each value
/// that has a part in it, and bit for bit independent of one that has not: the one solution of the grid hangs on it.
double interpolated(double a, double c, double cost) {
  if (a > c) std::swap(a, c);
  const double straight = a + cost;
  if (c >= straight) return straight;
  const double apart = c - a;
  const double slanted = (a + c + std::sqrt(std::max(0.0, 2 * cost * cost - apart * apart))) / 2;
  return std::clamp(slanted, std::nextafter(c, never), straight);
}

}  // namespace

Cell cell_at(const Place& place) { return {static_cast<int>(std::floor(place.row)), static_cast<int>(std::floor(place.column))}; }
Place centre_of(const Cell& cell) { return {cell.row + 0.5, cell.column + 0.5}; }

Navigation::Navigation(int rows, int columns) : rows_(rows), columns_(columns) {
  const size_t cells = static_cast<size_t>(rows) * static_cast<size_t>(columns);
  speed_.assign(cells, 1);
  value_.assign(cells, never);
  due_.assign(cells, never);
  key_.assign(cells, -1);
}

void Navigation::set_speed(const Cell& cell, double speed) {
  if (speed_[index(cell)] == speed) return;
  speed_[index(cell)] = speed;
  update(cell);
}

void Navigation::set_goal(const Cell& cell) {
  std::fill(value_.begin(), value_.end(), never);
  std::fill(due_.begin(), due_.end(), never);
  std::fill(key_.begin(), key_.end(), -1.0);
  queue_ = {};
  goal_ = cell;
  update(cell);
}

double Navigation::around(int row, int column) const { return holds({row, column}) ? value_[index({row, column})] : never; }

double Navigation::expected(const Cell& cell) const {
  const double speed = speed_[index(cell)];
  if (!(speed > 0)) return never;
  if (cell == goal_) return 0;
  return interpolated(std::min(around(cell.row - 1, cell.column), around(cell.row + 1, cell.column)),
                      std::min(around(cell.row, cell.column - 1), around(cell.row, cell.column + 1)), 1 / speed);
}

void Navigation::update(const Cell& cell) {
  const Index i = index(cell);
  due_[i] = expected(cell);
  const double key = due_[i] == value_[i] ? -1 : std::min(due_[i], value_[i]);
  if (key >= 0 && key != key_[i]) queue_.push({key, i});
  key_[i] = key;
}

void Navigation::update_neighbours(const Cell& cell) {
  for (const Cell& side : sides) {
    const Cell next{cell.row + side.row, cell.column + side.column};
    if (holds(next)) update(next);
  }
}

size_t Navigation::propagate() {
  size_t calculated = 0;
  while (!queue_.empty()) {
    const auto [key, i] = queue_.top();
    queue_.pop();
    if (key != key_[i]) continue;
    key_[i] = -1;
    ++calculated;
    const Cell cell{static_cast<int>(i) / columns_, static_cast<int>(i) % columns_};
    if (value_[i] > due_[i]) {
      value_[i] = due_[i];
    } else {  // too cheap: forget it and all that came from it; what else leads here is found when its turn comes
      value_[i] = never;
      update(cell);
    }
    update_neighbours(cell);
  }
  return calculated;
}

std::vector<Place> Navigation::path(Place start) const {
  std::vector<Place> way;
  Cell cell = cell_at(start);
  if (!queue_.empty() || !holds(cell) || !std::isfinite(cost(cell))) return way;
  way.push_back(start);
  while (cell != goal_) {  // ends: within a cell the direction stays the same, and costs fall from cell to cell
    way.push_back(downhill(cell, way.back()));
    cell = cell_at(way.back());
  }
  way.push_back(centre_of(goal_));
  return way;
}

/// One step against the gradient; where that leads nowhere, to the centre of the cheapest neighbour, which is cheaper than this cell.
Place Navigation::downhill(const Cell& cell, const Place& at) const {
  const double here = cost(cell);
  const double up = around(cell.row - 1, cell.column), down = around(cell.row + 1, cell.column);
  const double left = around(cell.row, cell.column - 1), right = around(cell.row, cell.column + 1);
  const double fall_row = std::max(0.0, here - std::min(up, down)), fall_column = std::max(0.0, here - std::min(left, right));
  const double length = std::hypot(fall_row, fall_column);
  const Place next{at.row + step * (up < down ? -fall_row : fall_row) / length,
                   at.column + step * (left < right ? -fall_column : fall_column) / length};
  const Cell to = cell_at(next);
  // Into the cell at a corner too: both cells beside such a step lie down the gradient, and are no obstacles.
  if (to == cell || (holds(to) && cost(to) < here)) return next;
  const auto cheapest = std::min_element(sides.begin(), sides.end(), [&](const Cell& a, const Cell& b) {
    return around(cell.row + a.row, cell.column + a.column) < around(cell.row + b.row, cell.column + b.column);
  });
  return centre_of({cell.row + cheapest->row, cell.column + cheapest->column});
}

}  // namespace planner
