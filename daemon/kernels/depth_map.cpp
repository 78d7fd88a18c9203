// depth_map.cpp: the plain form of counting by column.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/depth_map.h"

#include <algorithm>

namespace vdisp::kernels::plain {

void count_depth(Plane<const int16_t> disparity, Plane<int16_t> counts, uint8_t*) {
  for (int d = 0; d < counts.height; ++d) std::fill_n(counts.row(d), counts.width, int16_t{0});
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) {
      const int d = disparity.row(y)[x] / 16;
      if (d < 1 || d >= counts.height) continue;
      int16_t& count = counts.row(d)[x];
      if (count < INT16_MAX) ++count;
    }
  }
}

}  // namespace vdisp::kernels::plain
