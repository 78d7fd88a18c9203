// prefilter.cpp: the plain form of the pre-filters: obvious before fast, and what runs where no instruction set is known.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/prefilter.h"

#include <algorithm>

namespace vdisp::kernels::plain {

void x_sobel(View8 in, int cap, int first, int last, Plane<uint8_t> out) {
  for (int y = first; y < last; ++y) {
    const int border = in.height > 1 ? 1 : 0;
    const uint8_t* above = in.row(y > 0 ? y - 1 : border);
    const uint8_t* here = in.row(y);
    const uint8_t* below = in.row(y + 1 < in.height ? y + 1 : in.height - 1 - border);
    uint8_t* to = out.row(y);
    to[0] = to[in.width - 1] = static_cast<uint8_t>(cap);
    for (int x = 1; x + 1 < in.width; ++x) {
      const int gradient = above[x + 1] - above[x - 1] + 2 * (here[x + 1] - here[x - 1]) + below[x + 1] - below[x - 1];
      to[x] = static_cast<uint8_t>(std::clamp(gradient, -cap, cap) + cap);
    }
  }
}

}  // namespace vdisp::kernels::plain
