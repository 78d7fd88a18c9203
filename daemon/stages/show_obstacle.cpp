// show_obstacle.cpp: one comparison a pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/show_obstacle.h"

namespace vdisp {

ImageSpec ShowObstacle::accept(const ImageSpec& disparity, const ImageSpec& limit) {
  require(disparity, Pixel::disparity16, "the disparity");
  require(limit, Pixel::line16, "the limit");
  return {Pixel::mask8, 0, disparity.width, disparity.height};
}

bool ShowObstacle::combine(const Image& disparity, const Image& limit, Image& out) noexcept {
  const int16_t* rows = limit.row<int16_t>(0);
  for (int v = 0; v < out.spec.height; ++v) {
    const int16_t* d = disparity.row<int16_t>(v);
    uint8_t* mask = out.row<uint8_t>(v);
    for (int u = 0; u < out.spec.width; ++u) mask[u] = above_limit(disparity.camera, rows, v, d[u]) ? 255 : 0;
  }
  return true;
}

}  // namespace vdisp
