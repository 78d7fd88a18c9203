// map_changes.cpp: one comparison a cell; a list where it fits, else the reason why the whole grid has to be read.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map_changes.h"

namespace vdisp {
namespace {

/// True where a cell of both grids is the same piece of ground. View and count of an obstacle do not move cells, nor does the rover those
/// of the odometry frame.
bool same_place(const GridGeometry& a, const GridGeometry& b) {
  const bool same_pose = a.pose_x == b.pose_x && a.pose_y == b.pose_y && a.pose_yaw == b.pose_yaw;
  return a.cell == b.cell && a.origin_row == b.origin_row && a.origin_column == b.origin_column && a.frame == b.frame &&
         (same_pose || a.frame == grid_of_odometry);
}

}  // namespace

std::vector<ImageSpec> MapComparison::check(std::span<const ImageSpec> in) {
  if (in.size() != 1) throw FormatError("takes the occupancy, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::int8, "the occupancy");
  last_.assign(static_cast<size_t>(in[0].width) * in[0].height, -1);
  generation_ = 0;
  compares_ = false;
  return {record_spec<MapChanges>()};
}

void MapComparison::begin_anew() noexcept {
  std::fill(last_.begin(), last_.end(), int8_t{-1});
  compares_ = false;  // the generation goes on: a reader may hold any that this epoch ever had
}

/// `no`: the last grid was of the frame before this one, and of the same ground.
WholeGrid MapComparison::comparable(const Image& grid) const noexcept {
  if (!compares_ || grid.epoch != epoch_) return WholeGrid::first;
  if (grid.sequence != sequence_ + 1) return WholeGrid::after_blind;
  return same_place(grid.grid, geometry_) ? WholeGrid::no : WholeGrid::moved;
}

void MapComparison::compare(const Image& grid, MapChanges& changes) noexcept {
  const bool listed = changes.whole == WholeGrid::no;
  int8_t* last = last_.data();
  for (uint16_t row = 0; row < grid.spec.height; ++row) {
    const int8_t* now = grid.row<int8_t>(row);
    for (uint16_t column = 0; column < grid.spec.width; ++column, ++last) {
      if (listed && now[column] == *last) continue;
      *last = now[column];
      if (listed && changes.changed < MapChanges::capacity) changes.cells[changes.changed] = {row, column, *last, 0};
      ++changes.changed;
    }
  }
  if (listed && changes.changed > MapChanges::capacity) changes.whole = WholeGrid::overflow;
  if (changes.whole == WholeGrid::no) changes.count = changes.changed;
}

Outcome MapComparison::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& grid = *in[0];
  MapChanges& changes = make_record<MapChanges>(*out[0]);
  changes.whole = comparable(grid);
  if (grid.epoch != epoch_) generation_ = 0;
  changes.previous = generation_;
  compare(grid, changes);
  if (changes.changed > 0) ++generation_;
  changes.generation = generation_;
  sequence_ = grid.sequence;
  epoch_ = grid.epoch;
  geometry_ = grid.grid;
  compares_ = true;
  return Outcome::valid;
}

}  // namespace vdisp
