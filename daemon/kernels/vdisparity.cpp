// vdisparity.cpp: the plain form of counting disparities: a counter for each, row by row.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/vdisparity.h"

#include <algorithm>

namespace vdisp::kernels::plain {

void count_votes(Plane<const int16_t> disparity, int first, int last, const Search& search, Plane<int16_t> votes, uint16_t*) {
  for (int v = first; v < last; ++v) {
    const int16_t* d = disparity.row(v);
    int16_t* row = votes.row(v);
    std::fill_n(row, votes.width, int16_t{0});
    for (int u = 0; u < disparity.width; ++u) {
      if (!search.counts(d[u])) continue;
      int16_t& count = row[d[u] - search.first];
      if (count < INT16_MAX) ++count;
    }
  }
}

}  // namespace vdisp::kernels::plain
