// census.h: contracts: census codes: which pixels of a small neighbourhood are brighter. Brightness and contrast of a view change nothing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Rows [first, last) of the census of `in`: a bit for each of the eight neighbours, set where the centre is brighter than it, row by row
/// from the upper left one in the highest bit (Kueblbeck, Ach, Ernst 2005, 2.2; Zabih and Woodfill). Rows and columns beyond the image
/// repeat its border. `out` has the size of `in`, is not `in`; other rows are not touched.
using Census3x3 = void(View8 in, int first, int last, Plane<uint8_t> out);

/// The same of 5x5 pixels, each compared with its mirror image about the centre: a bit for each of the twelve before the centre, set where
/// it is brighter than its image. Row by row: eight in `out`, from the highest bit on, four in `more`, bits 3 to 0.
using Census5x5 = void(View8 in, int first, int last, Plane<uint8_t> out, Plane<uint8_t> more);

namespace plain {

Census3x3 census3x3;
Census5x5 census5x5;

/// One pixel of a row; `rows` are those around it, from above.
inline uint8_t census3x3_at(const uint8_t* const* rows, int x, int width) {
  const int columns[] = {std::max(x - 1, 0), x, std::min(x + 1, width - 1)};
  int code = 0;
  for (int i = 0; i < 9; ++i) {
    if (i != 4) code = 2 * code + (rows[1][x] > rows[i / 3][columns[i % 3]]);
  }
  return static_cast<uint8_t>(code);
}

/// Twelve bits: eight for `out`, then four for `more`.
inline int census5x5_at(const uint8_t* const* rows, int x, int width) {
  int columns[5], code = 0;
  for (int i = 0; i < 5; ++i) columns[i] = std::clamp(x + i - 2, 0, width - 1);
  for (int i = 0; i < 12; ++i) code = 2 * code + (rows[i / 5][columns[i % 5]] > rows[4 - i / 5][columns[4 - i % 5]]);
  return code;
}

}  // namespace plain

/// The `count` rows around y, those beyond the image repeating its border.
inline void rows_around(View8 in, int y, int count, const uint8_t** rows) {
  for (int i = 0; i < count; ++i) rows[i] = in.row(std::clamp(y + i - count / 2, 0, in.height - 1));
}

}  // namespace vdisp::kernels
