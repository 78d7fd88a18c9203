// evidence.cpp: pixel by pixel.
// SPDX-License-Identifier: Apache-2.0
#include "probe/evidence.h"

#include <algorithm>

namespace vdisp {

Tally tally_of(const Image& disparity, const Image& surface, const CellView& view) {
  Tally tally;
  const double least = (1 - depth_share) * view.disparity_far - depth_off, most = (1 + depth_share) * view.disparity_near + depth_off;
  for (int v = view.top; v < view.bottom; ++v) {
    const int16_t* disparities = disparity.row<int16_t>(v);
    const uint8_t* codes = surface.row<uint8_t>(v);
    for (int u = view.left; u < view.right; ++u) {
      ++tally.surfaces[codes[u]];
      const uint8_t code = rejected_code(disparities[u]);
      ++tally.rejected[code];
      if (code) continue;
      const double d = disparities[u] / 16.0;
      ++(d > most ? tally.nearer : d < least ? tally.farther : tally.there);
    }
  }
  return tally;
}

int points_around(const Image& map, const MapCell& cell) {
  int sum = 0;
  for (int row = std::max(cell.row - 1, 0); row <= std::min(cell.row + 1, map.spec.height - 1); ++row)
    sum += map.row<int16_t>(row)[cell.column];
  return sum;
}

Standing standing_in(const MapCell& cell, const Image& disparity, const Image& surface, const Reprojection& reprojection) {
  const int width = disparity.spec.width, height = disparity.spec.height;
  Standing standing{0, 0, width, -1, height, -1, 1e9, -1e9};
  for (int v = 0; v < height; ++v) {
    const int16_t* row = disparity.row<int16_t>(v);
    for (int u = 0; u < width; ++u) {
      const double d = row[u] / 16.0;
      if (rejected_code(row[u]) || reprojection.cell_of(u, v, d) != cell) continue;
      ++standing.pixels;
      standing.filled += surface.row<uint8_t>(v)[u] == static_cast<uint8_t>(Surface::filled);
      standing.left = std::min(standing.left, u);
      standing.right = std::max(standing.right, u);
      standing.top = std::min(standing.top, v);
      standing.bottom = std::max(standing.bottom, v);
      standing.least = std::min(standing.least, d);
      standing.most = std::max(standing.most, d);
    }
  }
  return standing;
}

}  // namespace vdisp
