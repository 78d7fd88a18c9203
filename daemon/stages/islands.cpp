// islands.cpp: part of `occupancy`: obstacles of one cell, and patches of floor that nothing leads to.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr size_t least_island = 8;  // cells
constexpr int suspected = 50;       // percent: an obstacle that is likely to be one is a neighbour too

}  // namespace

/// What stands in one cell alone takes twice the pixels: a false match of a few windows fills one cell of those that are as wide, hardly
/// two. It stays suspected, as much as a cell can be that is none: what stands there in frame after frame adds up. What is beside the map
/// is not known.
void Occupancy::doubt_lone(const Inputs& in, Image& occupancy, const Image& reason) const noexcept {
  const auto stands = [&](int row, int column) {
    return occupancy.row<int8_t>(row)[column] >= suspected &&
           reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(CellReason::obstacle);
  };
  for (int row = 1; row + 1 < rows_; ++row) {
    if (windows(in, row) < 1) break;
    for (int column = 1; column + 1 < columns_; ++column) {
      int8_t& value = occupancy.row<int8_t>(row)[column];
      if (value < occupied_from || !stands(row, column)) continue;
      int near = -1;  // but itself
      for (int r = row - 1; r <= row + 1; ++r)
        for (int c = column - 1; c <= column + 1; ++c) near += stands(r, c);
      if (near > 0) continue;
      const int half = static_cast<int>(100 - 10 * std::sqrt(100.0 - value));
      if (half < occupied_from) value = static_cast<int8_t>(occupied_from - 1);
    }
  }
}

void Occupancy::islands(Image& occupancy, Image& reason) noexcept {
  const auto is_floor = [&](int cell) {
    return reason.row<uint8_t>(cell / columns_)[cell % columns_] == static_cast<uint8_t>(CellReason::floor);
  };
  std::fill(known_.begin(), known_.end(), uint8_t{0});
  for (int begin = 0; begin < rows_ * columns_; ++begin) {
    if (known_[static_cast<size_t>(begin)] || !is_floor(begin)) continue;
    island_.clear();
    const auto take = [&](int cell) {
      known_[static_cast<size_t>(cell)] = 1;
      island_.push_back(cell);
    };
    take(begin);
    for (size_t i = 0; i < island_.size(); ++i) {
      const int row = island_[i] / columns_, column = island_[i] % columns_;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c)
          if (const int cell = r * columns_ + c; !known_[static_cast<size_t>(cell)] && is_floor(cell)) take(cell);
      }
    }
    if (island_.size() >= least_island) continue;
    for (const int cell : island_) {
      occupancy.row<int8_t>(cell / columns_)[cell % columns_] = -1;
      reason.row<uint8_t>(cell / columns_)[cell % columns_] = static_cast<uint8_t>(CellReason::speckle);
    }
  }
}

/// Beside an edge or an obstacle the matcher's window sees floor up to half its width too far, which is less than half a cell. Where the
/// ground goes on, more of it is seen.
void Occupancy::refuse_partly(Image& occupancy, Image& reason) const noexcept {
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const CellReason partly = partly_[static_cast<size_t>(row * columns_ + column)];
      uint8_t& why = reason.row<uint8_t>(row)[column];
      if (partly == CellReason::floor || why != static_cast<uint8_t>(CellReason::floor)) continue;
      int8_t& value = occupancy.row<int8_t>(row)[column];
      const bool suspect = value >= suspected;
      if (!suspect) value = -1;
      why = static_cast<uint8_t>(suspect ? CellReason::obstacle : partly);
    }
  }
}

}  // namespace vdisp
