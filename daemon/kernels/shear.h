// shear.h: contracts: views moved row by row so that the floor expected stands still in them, and views in the mirror.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// A plane's disparity, as it changes along one row: `at_zero` at column 0, `per_column` more from column to column, both in 1/65536 of
/// 1/16 px. It is taken as constant over blocks of `tilt_block` columns.
struct RowDisparity {
  int64_t at_zero = 0;
  int64_t per_column = 0;

  /// In 1/16 px, rounded down.
  int at(int column) const {
    return static_cast<int>((at_zero + per_column * (per_column ? column / tilt_block * tilt_block + tilt_block / 2 : 0)) >> 16);
  }
  static constexpr int tilt_block = 8;
};

/// out[x] = in[x - disparity.at(x) / 16], between two pixels interpolated linearly and rounded; beyond either end the last pixel.
using ShearRow = void(const uint8_t* in, int width, const RowDisparity& disparity, uint8_t* out);

/// out[x] = in[width - 1 - x].
using MirrorRow = void(const uint8_t* in, int width, uint8_t* out);

namespace plain {
ShearRow shear_row;
MirrorRow mirror_row;
}  // namespace plain

}  // namespace vdisp::kernels
