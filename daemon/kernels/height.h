// height.h: contract: how high above the local floor each pixel of a row lies, and what that makes of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "daemon/kernels/search.h"

namespace vdisp::kernels {

/// What a pixel is, by its height over the local floor.
enum class Surface : uint8_t {
  none = 0,  ///< no disparity that counts
  floor,     ///< lower than the step that the rover does not climb, higher than the hole that counts
  obstacle,  ///< from that step on, and in the way
  overhang,  ///< so high that the rover passes below
  below,     ///< from that hole on downwards
  filled,    ///< obstacle, without a disparity of its own: the kernel makes none of these
};

/// height = camera - scale * d_floor / d' - profile[d], mm, where d_floor = first + u * step is the plane's true disparity at column u.
/// `camera` and `scale` are both the height of the camera, mm.
struct HeightRow {
  float camera, first, step;
  int step_mm;       ///< from here on: obstacle
  int clearance_mm;  ///< from here on: overhang
  int hole_mm;       ///< positive; from minus this on downwards: below
};

/// Per raw disparity, from search.first on: inverse = camera / d' of it, profile = height of the local floor over the plane, mm.
struct HeightOf {
  float inverse, profile;
};
using HeightTable = const HeightOf*;

/// One row of `n` disparities: height in mm, rounded towards zero and held within +-32000 (`none` where there is no disparity), the
/// surface, and the disparity again where it is an obstacle and where it is an overhang, else `refused`.
struct HeightOut {
  int16_t* height;
  uint8_t* surface;
  int16_t *obstacles, *overhangs;
  int16_t none, refused;
};
using MeasureHeights = void(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                            const HeightOut& out);

namespace plain {
MeasureHeights measure_heights;
}

}  // namespace vdisp::kernels
