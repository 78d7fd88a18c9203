// shear.cpp: the plain form of shear and mirror.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/shear.h"

#include <algorithm>

namespace vdisp::kernels::plain {

void shear_row(const uint8_t* in, int width, const RowDisparity& disparity, uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const int from = 16 * x - disparity.at(x), whole = from >> 4, part = from & 15;
    const int left = in[std::clamp(whole, 0, width - 1)], right = in[std::clamp(whole + 1, 0, width - 1)];
    out[x] = static_cast<uint8_t>((left * (16 - part) + right * part + 8) >> 4);
  }
}

void mirror_row(const uint8_t* in, int width, uint8_t* out) { std::reverse_copy(in, in + width, out); }

}  // namespace vdisp::kernels::plain
