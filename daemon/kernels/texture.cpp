// texture.cpp: the plain form of the texture measure.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/texture.h"

#include <cstdlib>

namespace vdisp::kernels::plain {

void texture_row(View8 gradient, int zero, int window, int row, bool fresh, uint16_t* columns, uint16_t* out) {
  const int r = window / 2;
  const auto strength = [&](int x, int y) { return std::abs(gradient.row(y)[x] - zero); };
  for (int x = 0; x < gradient.width; ++x) {
    int sum = 0;
    if (fresh) {
      for (int y = row - r; y <= row + r; ++y) sum += strength(x, y);
    } else {
      sum = columns[x] + strength(x, row + r) - strength(x, row - r - 1);
    }
    columns[x] = static_cast<uint16_t>(sum);
  }
  int sum = 0;
  for (int x = 0; x < gradient.width; ++x) {
    sum += columns[x];
    if (x >= window) sum -= columns[x - window];
    if (x >= window - 1) out[x - r] = static_cast<uint16_t>(sum);
  }
}

}  // namespace vdisp::kernels::plain
