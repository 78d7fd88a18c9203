// followed_map.h: a planner's own copy of the map, kept up to date by lists of changes, and how fast it may drive in each cell.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "navigation.h"
#include "vdisp/records.h"

namespace planner {

/// How occupancy becomes speed (1: free ground, 0: never). Below `occupied` a tenth less for each full ten percent: in whole tenths,
/// because a percent more or less in each frame is noise, and no reason to plan again.
struct Policy {
  double unknown_speed = 0.5;  ///< in cells that nobody has seen; 0: only over ground that was seen
  int occupied = 65;           ///< from this occupancy on, in percent, a cell is an obstacle
  double buffer_m = 0.3;       ///< around obstacles the rover slows down this far, to a tenth beside them
  double radius_m = 0;         ///< of the rover: cells whose centre is as near to an obstacle's are obstacles too, and the buffer is beyond
};

/// How much of a frame was read.
enum class Read {
  nothing,  ///< the copy has it already
  listed,   ///< the cells of the list
  whole,    ///< all cells
  refused,  ///< blind, or not what was asked for: nothing is known any more
};

/// Follows `occupancy` and `map_changes`, as docs/wire-format.md says.
class FollowedMap {
 public:
  explicit FollowedMap(const Policy& policy) : policy_(policy) {}

  /// The two images of one frame; null or blind ones make it forget.
  Read follow(const vdisp::Image* occupancy, const vdisp::Image* changes);
  /// What is blind, stale or dead is not known: the next frame is read whole.
  void forget() { generation_ = 0; }
  bool known() const { return generation_ != 0; }

  /// Cells whose speed the last follow() changed; feed a Navigation with them. All of them where the size is another.
  const std::vector<Cell>& changed() const { return changed_; }
  double speed(const Cell& cell) const { return speed_[index(cell)]; }
  int8_t occupancy(const Cell& cell) const { return value_[index(cell)]; }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  const vdisp::GridGeometry& grid() const { return grid_; }

 private:
  struct Offset {
    Cell cell;
    double distance;  // cells
  };
  size_t index(const Cell& cell) const {
    return static_cast<size_t>(cell.row) * static_cast<size_t>(columns_) + static_cast<size_t>(cell.column);
  }
  bool holds(const Cell& cell) const { return cell.row >= 0 && cell.column >= 0 && cell.row < rows_ && cell.column < columns_; }
  void resize(const vdisp::Image& occupancy);
  bool take_listed(const vdisp::MapChanges& changes);
  void take_whole(const vdisp::Image& occupancy);
  void put(const Cell& cell, int8_t value);
  void mark(const Cell& cell);
  double wanted_speed(const Cell& cell) const;
  void settle();

  Policy policy_;
  int rows_ = 0, columns_ = 0;
  vdisp::GridGeometry grid_{};
  uint64_t epoch_ = 0, generation_ = 0;  // what the copy is a copy of; generation 0: of nothing
  std::vector<int8_t> value_;
  std::vector<double> speed_;
  std::vector<uint8_t> marked_;
  std::vector<Cell> marks_, changed_;
  double radius_ = 0, buffer_ = 0;  // cells
  std::vector<Offset> around_;      // the cells within radius and buffer, nearest first
};

/// A point of the rover's frame (m; x ahead, y left) in a grid of the camera's frame, and back.
Place grid_place(const vdisp::GridGeometry& grid, double x, double y);
std::pair<double, double> rover_place(const vdisp::GridGeometry& grid, const Place& place);

}  // namespace planner
