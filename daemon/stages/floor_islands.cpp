// floor_islands.cpp: part of `occupancy`: patches of floor that nothing leads to.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr size_t least_island = 8;  // cells

}  // namespace

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

}  // namespace vdisp
