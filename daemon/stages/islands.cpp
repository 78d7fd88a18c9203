// islands.cpp: part of `occupancy`: obstacles of one cell or of few pixels, and patches of floor that nothing leads to.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr size_t least_island = 8;     // cells
constexpr double least_windows = 1.5;  // of pixels, that are no false match
constexpr int suspected = 50;          // percent: an obstacle that is likely to be one is a neighbour too

}  // namespace

/// The cells that hang together with `begin`, into island_, and marks them in known_.
template <class Is>
void Occupancy::find_patch(int begin, Is is) noexcept {
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
        if (const int cell = r * columns_ + c; !known_[static_cast<size_t>(cell)] && is(cell)) take(cell);
    }
  }
}

/// Whether what stands in island_ is narrow, has hardly more pixels than a window of the matcher, and is seen to its end. So far off that
/// the least object has no more: of a greater one that is hardly matched few pixels may be all there is, if it hides the floor behind it.
/// Of what goes on beyond the map's far border more is seen when it comes nearer; what is beside the map is
/// not known.
bool Occupancy::may_be_false(const Inputs& in, const Image& reason) noexcept {
  const int side = config_.image_source.corrsize;
  int pixels = 0, first = columns_, last = 0, nearest = island_.front();
  counted_.clear();
  for (const int cell : island_) {
    const int row = cell / columns_, column = cell % columns_;
    first = std::min(first, column);
    last = std::max(last, column);
    nearest = std::max(nearest, cell);
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) {
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c) {
        const int beside = r * columns_ + c;
        if (obstacles_[static_cast<size_t>(beside)] == 0 || std::find(counted_.begin(), counted_.end(), beside) != counted_.end()) continue;
        counted_.push_back(beside);
        pixels += obstacles_[static_cast<size_t>(beside)];
      }
    }
    if (pixels >= least_windows * side * side) return false;
  }
  const int row = nearest / columns_;
  if (first == 0 || last == columns_ - 1 || row == rows_ - 1 || last - first + 1 > windows(in, row)) return false;
  if (least_object(in, box(in, row, nearest % columns_)) >= least_windows * side * side &&
      !std::all_of(island_.begin(), island_.end(), [&](int cell) { return hides_no_floor(in, cell, reason); }))
    return false;
  return std::all_of(island_.begin(), island_.end(),
                     [&](int cell) { return part_in_view(in, box(in, cell / columns_, cell % columns_)) >= 1; });
}

/// What stands alone in one cell, or has no more pixels than a false match, stays suspected, as much as a cell can be that is none: what is
/// there in frame after frame adds up. One cell takes twice the pixels, if a few windows are as wide: a false match fills hardly two of
/// these. At the rim of the view a cell may show all that is seen of something larger.
void Occupancy::doubt_lone(const Inputs& in, Image& occupancy, const Image& reason) noexcept {
  const auto stands = [&](int cell) {
    return occupancy.row<int8_t>(cell / columns_)[cell % columns_] >= suspected &&
           reason.row<uint8_t>(cell / columns_)[cell % columns_] == static_cast<uint8_t>(CellReason::obstacle);
  };
  for (int cell = 0; cell < rows_ * columns_; ++cell)
    standing_[static_cast<size_t>(cell)] = stands(cell) && occupancy.row<int8_t>(cell / columns_)[cell % columns_] >= occupied_from;
  std::fill(known_.begin(), known_.end(), uint8_t{0});
  for (int begin = 0; begin < rows_ * columns_; ++begin) {
    if (known_[static_cast<size_t>(begin)] || !stands(begin)) continue;
    find_patch(begin, stands);
    const int row = begin / columns_, column = begin % columns_;
    const bool inside = row > 0 && row + 1 < rows_ && column > 0 && column + 1 < columns_;
    const bool few = may_be_false(in, reason);
    const bool lone = island_.size() == 1 && inside && windows(in, row) >= 1 && part_in_view(in, box(in, row, column)) >= 1;
    for (const int cell : island_) {
      int8_t& value = occupancy.row<int8_t>(cell / columns_)[cell % columns_];
      const int half = static_cast<int>(100 - 10 * std::sqrt(100.0 - value));
      if (value >= occupied_from && (few || (lone && half < occupied_from))) value = static_cast<int8_t>(occupied_from - 1);
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
    find_patch(begin, is_floor);
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
