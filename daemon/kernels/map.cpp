// map.cpp: the plain forms: each pixel asked whether it is above the limit, and put into its cell.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/map.h"

namespace vdisp::kernels {

GroundScratch::GroundScratch(int width, int columns)
    : depth(static_cast<size_t>(columns)),
      across(static_cast<size_t>(width) + 64),
      drop(across.size()),
      cells(across.size()),
      doubtful(across.size()) {}

namespace plain {
namespace {

bool above(const Search& search, const int16_t* limit, int v, int d) { return search.counts(d) && limit[d - search.first] > v; }

}  // namespace

void mark_above(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, Plane<uint8_t> mask) {
  for (int v = 0; v < disparity.height; ++v) {
    const int16_t* d = disparity.row(v);
    uint8_t* to = mask.row(v);
    for (int u = 0; u < disparity.width; ++u) to[u] = above(search, limit, v, d[u]) ? 255 : 0;
  }
}

void count_cells(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, const Ground& ground, Plane<int16_t> map,
                 GroundScratch&) {
  for (int v = 0; v < disparity.height; ++v) {
    const int16_t* d = disparity.row(v);
    for (int u = 0; u < disparity.width; ++u) {
      if (!above(search, limit, v, d[u])) continue;
      const int cell = ground.cell_of(u, v, d[u], static_cast<int>(map.stride));
      if (cell >= 0 && map.data[cell] < INT16_MAX) ++map.data[cell];
    }
  }
}

}  // namespace plain
}  // namespace vdisp::kernels
