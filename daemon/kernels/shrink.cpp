// shrink.cpp: the plain form of averaging areas.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/shrink.h"

namespace vdisp::kernels::plain {

void shrink(View8 in, int factor, int first, int last, Plane<uint8_t> out) {
  const int area = factor * factor;
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < out.width; ++x) {
      int sum = area / 2;
      for (int i = 0; i < area; ++i) sum += in.row(y * factor + i / factor)[x * factor + i % factor];
      out.row(y)[x] = static_cast<uint8_t>(sum / area);
    }
  }
}

}  // namespace vdisp::kernels::plain
