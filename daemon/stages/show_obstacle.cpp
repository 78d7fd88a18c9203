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

}  // namespace vdisp
