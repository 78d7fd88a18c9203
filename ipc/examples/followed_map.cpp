// followed_map.cpp: read the list where it is enough, the whole grid where it is not; slow down beside obstacles.
// SPDX-License-Identifier: Apache-2.0
#include "followed_map.h"

#include <algorithm>
#include <cmath>

namespace planner {
namespace {

constexpr double nearly = 1e-6;  // cells: 0.3 m are three cells of 0.1 m, although 0.1 is a float

}  // namespace

using vdisp::Image;
using vdisp::MapChanges;
using vdisp::WholeGrid;

Read FollowedMap::follow(const Image* occupancy, const Image* changes) {
  changed_.clear();
  const MapChanges* record = changes && changes->valid() ? vdisp::record_of<MapChanges>(*changes) : nullptr;
  const bool grid = occupancy && occupancy->valid() && occupancy->spec.pixel == vdisp::Pixel::int8 && occupancy->grid.cell > 0;
  if (!record || !grid || occupancy->sequence != changes->sequence || occupancy->epoch != changes->epoch) {
    forget();
    return Read::refused;
  }
  const bool same_size = occupancy->spec.height == rows_ && occupancy->spec.width == columns_ && occupancy->grid.cell == grid_.cell;
  const bool mine = known() && occupancy->epoch == epoch_ && same_size;
  Read read = Read::whole;
  if (mine && record->generation == generation_)
    read = Read::nothing;
  else if (mine && record->previous == generation_ && record->whole == WholeGrid::no && take_listed(*record))
    read = Read::listed;
  if (!same_size) resize(*occupancy);
  if (read == Read::whole) take_whole(*occupancy);
  settle();
  grid_ = occupancy->grid;
  epoch_ = occupancy->epoch;
  generation_ = record->generation;
  return read;
}

/// Forgets all cells: of another size nothing can be kept.
void FollowedMap::resize(const Image& occupancy) {
  rows_ = occupancy.spec.height;
  columns_ = occupancy.spec.width;
  const size_t cells = static_cast<size_t>(rows_) * static_cast<size_t>(columns_);
  value_.assign(cells, -1);
  speed_.assign(cells, -1);  // none: each cell counts as changed
  marked_.assign(cells, 0);
  marks_.clear();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) mark({row, column});
  }
  const double cell = static_cast<double>(occupancy.grid.cell);
  radius_ = std::min(policy_.radius_m / cell, 50.0);
  buffer_ = std::min(policy_.buffer_m / cell, 50.0);
  const double farthest = radius_ + buffer_ + nearly;
  const int reach = static_cast<int>(farthest);
  around_.clear();
  for (int row = -reach; row <= reach; ++row) {
    for (int column = -reach; column <= reach; ++column) {
      const double distance = std::hypot(row, column);
      if (distance > 0 && distance <= farthest) around_.push_back({{row, column}, distance});
    }
  }
  std::stable_sort(around_.begin(), around_.end(), [](const Offset& a, const Offset& b) { return a.distance < b.distance; });
}

/// False where the list does not fit the grid: then nothing of it is to be trusted.
bool FollowedMap::take_listed(const MapChanges& changes) {
  const uint32_t count = changes.count;
  if (count > MapChanges::capacity) return false;
  for (uint32_t i = 0; i < count; ++i) {
    if (!holds({changes.cells[i].row, changes.cells[i].column})) return false;
  }
  for (uint32_t i = 0; i < count; ++i) put({changes.cells[i].row, changes.cells[i].column}, changes.cells[i].value);
  return true;
}

void FollowedMap::take_whole(const Image& occupancy) {
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) put({row, column}, occupancy.row<int8_t>(row)[column]);
  }
}

void FollowedMap::put(const Cell& cell, int8_t value) {
  int8_t& copy = value_[index(cell)];
  if (copy == value) return;
  const bool was = copy >= policy_.occupied, is = value >= policy_.occupied;
  copy = value;
  mark(cell);
  if (was == is) return;
  for (const Offset& offset : around_) {
    const Cell beside{cell.row + offset.cell.row, cell.column + offset.cell.column};
    if (holds(beside)) mark(beside);
  }
}

void FollowedMap::mark(const Cell& cell) {
  if (marked_[index(cell)]) return;
  marked_[index(cell)] = 1;
  marks_.push_back(cell);
}

double FollowedMap::wanted_speed(const Cell& cell) const {
  const int8_t value = occupancy(cell);
  if (value >= policy_.occupied) return 0;
  const double speed = value < 0 ? policy_.unknown_speed : (10 - value / 10) / 10.0;
  for (const Offset& offset : around_) {
    const Cell beside{cell.row + offset.cell.row, cell.column + offset.cell.column};
    if (holds(beside) && occupancy(beside) >= policy_.occupied)
      return offset.distance <= radius_ + nearly ? 0 : speed * std::clamp((offset.distance - std::max(radius_, 1.0)) / buffer_, 0.1, 1.0);
  }
  return speed;
}

/// Speeds of the marked cells; those that are other than before are what a planner has to hear.
void FollowedMap::settle() {
  for (const Cell& cell : marks_) {
    marked_[index(cell)] = 0;
    const double speed = wanted_speed(cell);
    if (speed == speed_[index(cell)]) continue;
    speed_[index(cell)] = speed;
    changed_.push_back(cell);
  }
  marks_.clear();
}

Place grid_place(const vdisp::GridGeometry& grid, double x, double y) {
  const double dx = x - static_cast<double>(grid.pose_x), dy = y - static_cast<double>(grid.pose_y),
               yaw = static_cast<double>(grid.pose_yaw);
  const double ahead = std::cos(yaw) * dx + std::sin(yaw) * dy, left = std::cos(yaw) * dy - std::sin(yaw) * dx;
  const double cell = static_cast<double>(grid.cell);
  return {static_cast<double>(grid.origin_row) - ahead / cell, static_cast<double>(grid.origin_column) - left / cell};
}

std::pair<double, double> rover_place(const vdisp::GridGeometry& grid, const Place& place) {
  const double cell = static_cast<double>(grid.cell), yaw = static_cast<double>(grid.pose_yaw);
  const double ahead = (static_cast<double>(grid.origin_row) - place.row) * cell;
  const double left = (static_cast<double>(grid.origin_column) - place.column) * cell;
  return {static_cast<double>(grid.pose_x) + std::cos(yaw) * ahead - std::sin(yaw) * left,
          static_cast<double>(grid.pose_y) + std::sin(yaw) * ahead + std::cos(yaw) * left};
}

}  // namespace planner
