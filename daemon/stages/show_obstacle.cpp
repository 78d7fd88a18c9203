// show_obstacle.cpp: one comparison a pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/show_obstacle.h"

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec ShowObstacle::accept(const ImageSpec& disparity, const ImageSpec& limit) {
  require(disparity, Pixel::disparity16, "the disparity");
  require(limit, Pixel::line16, "the limit");
  return {Pixel::mask8, 0, disparity.width, disparity.height};
}

bool ShowObstacle::combine(const Image& disparity, const Image& limit, Image& out) noexcept {
  machine_.kernels.mark_above(plane<int16_t>(disparity), search_of(disparity.camera, limit.spec.width), limit.row<int16_t>(0),
                              plane<uint8_t>(out));
  return true;
}

ImageSpec ShowSurface::accept(const ImageSpec& surface) {
  require(surface, Pixel::gray8, "the surface");
  return {Pixel::mask8, 0, surface.width, surface.height};
}

bool ShowSurface::filter(const Image& surface, Image& out) noexcept {
  for (int v = 0; v < out.spec.height; ++v) {
    const uint8_t* from = surface.row<uint8_t>(v);
    uint8_t* to = out.row<uint8_t>(v);
    for (int u = 0; u < out.spec.width; ++u)
      to[u] = from[u] == static_cast<uint8_t>(kernels::Surface::obstacle) || from[u] == static_cast<uint8_t>(kernels::Surface::filled) ? 255
                                                                                                                                       : 0;
  }
  return true;
}

}  // namespace vdisp
