// lens.h: the simulated cameras: their calibration, and for each pixel the ray it sees along.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/geometry/calibration.h"

namespace vdisp::sim {

/// The paper's camera (f = 576 px at 640, B = 0.09 m), with barrel distortion and misalignment in proportion to `distortion`.
Calibration make_calibration(const sim_section& parameters);

/// Where a camera without lens errors sees the pixel (u, v) of a raw one: x / z and y / z, in the raw camera's own axes. Searched
/// from where x and y are: a neighbour's place, or 0.
void undistort(const RawCamera& camera, double u, double v, double& x, double& y);

/// Rays of one camera in axes of the rectified view, (x, y, 1), in tiles; behind the right and lower border they go on.
struct Rays {
  static constexpr int tile_width = 16, tile_height = 8, tile_pixels = tile_width * tile_height;
  struct Bounds {
    float x0, x1, y0, y1;
  };
  int width = 0, height = 0, tiles_x = 0, tiles_y = 0;
  std::vector<float> x, y;     ///< tile by tile, rows of a tile one after the other
  std::vector<Bounds> bounds;  ///< of each tile, half a pixel wider
  std::vector<Bounds> rows;    ///< of each row of tiles
  int tiles() const { return tiles_x * tiles_y; }
};
Rays raw_rays(const RawCamera& camera, int width, int height);
Rays rectified_rays(const StereoView& view, int width, int height);

}  // namespace vdisp::sim
