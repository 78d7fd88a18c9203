// reach.cpp: a flood over the free cells.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/reach.h"

#include <algorithm>

namespace vdisp::sim {

Reach::Reach(const FloorPlan& plan, const Spot& start, const Spot& middle, double extent, double room)
    : corner_{middle.x - extent, middle.z - extent}, side_(static_cast<int>(std::ceil(2 * extent / cell))) {
  free_.resize(static_cast<size_t>(side_) * side_);
  for (size_t i = 0; i < free_.size(); ++i) free_[i] = plan.gap(spot(static_cast<int32_t>(i)), room) >= room;
  const int x = static_cast<int>((start.x - corner_.x) / cell), z = static_cast<int>((start.z - corner_.z) / cell);
  if (x < 0 || z < 0 || x >= side_ || z >= side_) return;
  const int32_t first = z * side_ + x;
  free_[static_cast<size_t>(first)] |= plan.gap(start, room) >= room;
  const std::vector<int32_t> came = spread(first);
  std::vector<int32_t> found{first};
  for (size_t i = 0; i < came.size(); ++i)
    if (came[i] >= 0 && static_cast<int32_t>(i) != first) found.push_back(static_cast<int32_t>(i));
  if (!free_[static_cast<size_t>(first)]) return;
  for (const int32_t index : found) {
    cells_.push_back(index);
    places_.push_back(spot(index));
    const int column = index % side_, row = index / side_;
    open_ = open_ || std::min(column, row) == 0 || std::max(column, row) == side_ - 1;
  }
}

Spot Reach::spot(int32_t index) const { return {corner_.x + (index % side_ + 0.5) * cell, corner_.z + (index / side_ + 0.5) * cell}; }

/// For each cell the one it was reached from; -1: it was not.
std::vector<int32_t> Reach::spread(int32_t from) const {
  std::vector<int32_t> came(free_.size(), -1), queue;
  if (!free_[static_cast<size_t>(from)]) return came;
  came[static_cast<size_t>(from)] = from;
  queue.push_back(from);
  for (size_t i = 0; i < queue.size(); ++i) {
    const int column = queue[i] % side_, row = queue[i] / side_;
    constexpr int steps[8][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (const auto& step : steps) {
      const int x = column + step[0], z = row + step[1];
      if (x < 0 || z < 0 || x >= side_ || z >= side_) continue;
      const int32_t next = z * side_ + x;
      if (!free_[static_cast<size_t>(next)] || came[static_cast<size_t>(next)] >= 0) continue;
      came[static_cast<size_t>(next)] = queue[i];
      queue.push_back(next);
    }
  }
  return came;
}

std::vector<Spot> Reach::way(size_t from, size_t to) const {
  const std::vector<int32_t> came = spread(cells_[to]);
  std::vector<Spot> way;
  for (int32_t at = cells_[from];; at = came[static_cast<size_t>(at)]) {
    way.push_back(spot(at));
    if (at == cells_[to]) return way;
  }
}

}  // namespace vdisp::sim
