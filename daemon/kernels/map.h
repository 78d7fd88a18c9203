// map.h: contracts: which pixels are obstacles, and in which cell of the ground each of them stands.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "daemon/kernels/aligned.h"
#include "daemon/kernels/plane.h"
#include "daemon/kernels/search.h"

namespace vdisp::kernels {

/// A pixel of row v is above the limit when its disparity counts and limit[column] > v; limit holds search.columns rows, in any order.
/// mask = 255 there, else 0.
using MarkAbove = void(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, Plane<uint8_t> mask);

/// A stereo view over a grid on the ground of square cells, `rows` x `columns`: row 0 is farthest, the camera stands behind the middle
/// of the last row. f and the centre in px, baseline and cell in m; angles as sines and cosines.
struct Ground {
  double f, cx, cy, baseline, cx_offset;
  double cos_pitch, sin_pitch, cos_roll, sin_roll;
  double cell;
  int rows, columns;

  /// Where in a grid of this stride the cell is in which a pixel with the disparity d (1/16 px) stands; -1 outside. These operations
  /// in this order are the definition: what comes near a border is decided by their rounding.
  int cell_of(int u, int v, int d, int stride) const {
    const double z = f * baseline / (d / 16.0 - cx_offset);
    const double x = (u - cx) * z / f, y = (v - cy) * z / f;
    const double across = x * cos_roll - y * sin_roll, down = x * sin_roll + y * cos_roll;
    const double ahead = z * cos_pitch - down * sin_pitch;
    const double row = rows - 1 - std::floor(ahead / cell), column = std::floor(across / cell + columns / 2.0);
    const bool inside = row >= 0 && row < rows && column >= 0 && column < columns;
    return inside ? static_cast<int>(row) * stride + static_cast<int>(column) : -1;
  }
};

/// Memory of count_cells for images of up to this width with up to this many columns of disparities.
struct GroundScratch {
  GroundScratch() = default;
  GroundScratch(int width, int columns);
  Aligned<float> depth, across, drop;
  Aligned<int32_t> cells, doubtful;
};

/// map[cell] = how many pixels above the limit stand in it, at most 32767. `map` has ground.rows x ground.columns cells, rows and strides
/// together fewer than 2^31, and is all 0 before. f, baseline and cell are above 0, search.least / 16 above cx_offset.
using CountCells = void(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, const Ground& ground,
                        Plane<int16_t> map, GroundScratch& scratch);

namespace plain {
MarkAbove mark_above;
CountCells count_cells;
}  // namespace plain

}  // namespace vdisp::kernels
