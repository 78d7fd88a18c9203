// census.cpp: the plain form of the census: obvious before fast, and what runs where no instruction set is known.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/census.h"

namespace vdisp::kernels::plain {

void census3x3(View8 in, int first, int last, Plane<uint8_t> out) {
  const uint8_t* rows[3];
  for (int y = first; y < last; ++y) {
    rows_around(in, y, 3, rows);
    for (int x = 0; x < in.width; ++x) out.row(y)[x] = census3x3_at(rows, x, in.width);
  }
}

void census5x5(View8 in, int first, int last, Plane<uint8_t> out, Plane<uint8_t> more) {
  const uint8_t* rows[5];
  for (int y = first; y < last; ++y) {
    rows_around(in, y, 5, rows);
    for (int x = 0; x < in.width; ++x) {
      const int code = census5x5_at(rows, x, in.width);
      out.row(y)[x] = static_cast<uint8_t>(code >> 4);
      more.row(y)[x] = static_cast<uint8_t>(code & 15);
    }
  }
}

}  // namespace vdisp::kernels::plain
