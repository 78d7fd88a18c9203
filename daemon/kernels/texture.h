// texture.h: contracts: how much there is to be matched in a window (SVS: confidence).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// For row `row`, window / 2 <= row < height - window / 2: the sum of |gradient - zero| over the window around each pixel, for columns
/// [window / 2, width - window / 2); other columns of `out` are left. |gradient - zero| <= 127, window odd, 1 .. 21: the sum fits.
/// `columns` holds the sums of the columns from call to call, width + texture_margin elements, as does `out`, whose elements from width
/// on are written, whatever they hold. With `fresh` they are made anew; else the last call was for row - 1.
using TextureRow = void(View8 gradient, int zero, int window, int row, bool fresh, uint16_t* columns, uint16_t* out);
inline constexpr int texture_margin = 96;

namespace plain {
TextureRow texture_row;
}

}  // namespace vdisp::kernels
