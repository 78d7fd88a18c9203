// prefilter.cpp: the plain form of the pre-filters: obvious before fast, and what runs where no instruction set is known.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/prefilter.h"

#include <algorithm>
#include <array>
#include <numeric>

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

namespace {

using Seven = std::array<int, 7>;
// The window's weights are those of boxes of window - 6 pixels.
constexpr Seven bell{0, 1, 2, 3, 2, 1, 0}, dent{1, 0, 0, -2, 0, 0, 1};

int weighted(const Seven& weights, const int* from) { return std::inner_product(weights.begin(), weights.end(), from, 0); }

}  // namespace

void log_filter(View8 in, int window, int cap, int first, int last, Plane<uint8_t> out) {
  constexpr int strip = 128;
  const int reach = window / 2, box = window - 6, shift = window == 9 ? 4 : 5;
  int smooth[strip + 10], second[strip + 10], sums[strip + 4];
  for (int y = first; y < last; ++y) {
    const uint8_t* rows[11];
    for (int k = 0; k < window; ++k) rows[k] = in.row(mirrored_at_border(y + k - reach, in.height));
    for (int from = 0; from < in.width; from += strip) {
      const int count = std::min(strip, in.width - from);
      for (int i = 0; i < count + window - 1; ++i) {
        const int x = mirrored_at_border(from + i - reach, in.width);
        Seven boxes{};
        for (int j = 0; j < 7; ++j)
          for (int k = 0; k < box; ++k) boxes[static_cast<size_t>(j)] += rows[j + k][x];
        smooth[i] = weighted(bell, boxes.data());
        second[i] = weighted(dent, boxes.data());
      }
      for (int i = 0; i < count + box - 1; ++i) {
        sums[i] = std::clamp(weighted(bell, second + i) + weighted(dent, smooth + i) + 2, INT16_MIN, INT16_MAX) >> 2;
      }
      for (int i = 0; i < count; ++i) {
        const int response = (std::accumulate(sums + i, sums + i + box, 0) + (1 << shift >> 1)) >> shift;
        out.row(y)[from + i] = static_cast<uint8_t>(std::clamp(response, -cap, cap) + cap);
      }
    }
  }
}

}  // namespace vdisp::kernels::plain
