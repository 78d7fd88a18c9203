// debayer.cpp: the plain form of the de-Bayer filter.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/debayer.h"

#include <algorithm>

namespace vdisp::kernels::plain {

uint8_t debayered(View8 in, const BayerRow& row, int x, int y) {
  const auto before = [](int i, int size) { return i > 0 ? i - 1 : std::min(1, size - 1); };
  const auto after = [](int i, int size) { return i + 1 < size ? i + 1 : std::max(i - 1, 0); };
  const int left = before(x, in.width), right = after(x, in.width);
  const uint8_t *above = in.row(before(y, in.height)), *here = in.row(y), *below = in.row(after(y, in.height));
  // Each four times the colour's mean.
  int own = 4 * here[x], green = above[x] + here[left] + here[right] + below[x];
  int other = above[left] + above[right] + below[left] + below[right];
  if (row.colour_first != (x % 2 == 0)) {
    green = 4 * here[x];
    own = 2 * (here[left] + here[right]);
    other = 2 * (above[x] + below[x]);
  }
  const auto weighted = [](int colour, int weight) { return (colour * 32 * weight + 16384) >> 15; };
  return static_cast<uint8_t>((weighted(own, row.own) + weighted(green, row.green) + weighted(other, row.other) + 64) >> 7);
}

void debayer(View8 in, Bayer pattern, int first, int last, Plane<uint8_t> out) {
  for (int y = first; y < last; ++y) {
    const BayerRow row(pattern, y);
    for (int x = 0; x < in.width; ++x) out.row(y)[x] = debayered(in, row, x, y);
  }
}

}  // namespace vdisp::kernels::plain
