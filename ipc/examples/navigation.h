// navigation.h: a navigation function over a grid, kept up to date cell by cell, and the way down it. Standard C++ only.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace planner {

struct Cell {
  int row = 0, column = 0;  ///< row 0 is farthest, as in the map
  bool operator==(const Cell&) const = default;
};

/// A point of the grid in cells: cell (r, c) covers [r, r + 1) x [c, c + 1).
struct Place {
  double row = 0, column = 0;
};
Cell cell_at(const Place& place);
Place centre_of(const Cell& cell);

/// The cost of the best way from each cell to the goal, in the manner of E* (Philippsen and Siegwart, ICRA 2005): the solution of
/// |grad T| = 1 / speed, interpolated between two neighbours, one of each axis, that lie nearer to the goal (the upwind ones of Sethian's
/// level sets), so that ways are not bound to the grid's directions. Where speeds change only cells whose cost changes by it are
/// calculated anew, in the order of D* Lite (Koenig and Likhachev, AAAI 2002). The result is that of planning anew to the last bit: what
/// a cell is worth depends on cheaper cells only, so there is one solution, and propagate() ends when each cell agrees with it.
class Navigation {
 public:
  /// Free ground everywhere, no goal.
  Navigation(int rows, int columns);

  /// `speed`: 1 is free ground, 0 an obstacle, in between: go round it if that is shorter. Cheap where it is what it was.
  void set_speed(const Cell& cell, double speed);
  /// Forgets all costs, keeps the speeds.
  void set_goal(const Cell& cell);
  /// Brings all costs up to date; the number of cells calculated on the way.
  size_t propagate();

  /// In cells of free ground; infinite: no way to the goal (or it is an obstacle). As of the last propagate().
  double cost(const Cell& cell) const { return value_[index(cell)]; }
  double speed(const Cell& cell) const { return speed_[index(cell)]; }
  const Cell& goal() const { return goal_; }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  bool holds(const Cell& cell) const { return cell.row >= 0 && cell.column >= 0 && cell.row < rows_ && cell.column < columns_; }

  /// From `start` to the goal's centre by descent, half a cell a step. Costs fall from cell to cell; a step never touches an obstacle nor
  /// squeezes between two that meet at a corner. Empty: there is no way, `start` is outside, or propagate() has not been called.
  std::vector<Place> path(Place start) const;

 private:
  using Index = size_t;
  Index index(const Cell& cell) const {
    return static_cast<Index>(cell.row) * static_cast<Index>(columns_) + static_cast<Index>(cell.column);
  }
  double around(int row, int column) const;
  double expected(const Cell& cell) const;
  void update(const Cell& cell);
  void update_neighbours(const Cell& cell);
  Place downhill(const Cell& cell, const Place& at) const;

  int rows_, columns_;
  Cell goal_{-1, -1};
  std::vector<double> speed_;
  std::vector<double> value_;  // the cost as it was told to the neighbours
  std::vector<double> due_;    // what it has to become, by the neighbours (D* Lite: rhs)
  std::vector<double> key_;    // in the queue with this key; below 0: not in it
  using Entry = std::pair<double, Index>;
  // Cells whose value is not what is due, cheapest first; entries with another key than the cell's are old, and skipped.
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue_;
};

}  // namespace planner
