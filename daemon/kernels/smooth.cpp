// smooth.cpp: the plain form of the smoothing.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/smooth.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace vdisp::kernels::plain {
namespace {

using Nine = std::array<uint8_t, 9>;

template <class Smooth>
void each_pixel(View8 in, int first, int last, Plane<uint8_t> out, Smooth smooth) {
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < in.width; ++x) {
      Nine nine;
      for (int i = 0; i < 9; ++i) {
        const int row = std::clamp(y + i / 3 - 1, 0, in.height - 1), column = std::clamp(x + i % 3 - 1, 0, in.width - 1);
        nine[static_cast<size_t>(i)] = in.row(row)[column];
      }
      out.row(y)[x] = smooth(nine);
    }
  }
}

}  // namespace

void mean3x3(View8 in, int first, int last, Plane<uint8_t> out) {
  each_pixel(in, first, last, out,
             [](const Nine& nine) { return static_cast<uint8_t>((std::accumulate(nine.begin(), nine.end(), 0) + 4) / 9); });
}

void median3x3(View8 in, int first, int last, Plane<uint8_t> out) {
  const auto middle = [](uint8_t a, uint8_t b, uint8_t c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); };
  // The median of nine is the median of three: the largest of the columns' least, the middle of their middles, the least of their largest.
  each_pixel(in, first, last, out, [&](const Nine& p) {
    const uint8_t least = std::max({std::min({p[0], p[3], p[6]}), std::min({p[1], p[4], p[7]}), std::min({p[2], p[5], p[8]})});
    const uint8_t most = std::min({std::max({p[0], p[3], p[6]}), std::max({p[1], p[4], p[7]}), std::max({p[2], p[5], p[8]})});
    return middle(least, middle(middle(p[0], p[3], p[6]), middle(p[1], p[4], p[7]), middle(p[2], p[5], p[8])), most);
  });
}

}  // namespace vdisp::kernels::plain
