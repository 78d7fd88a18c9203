// depth_map.cpp: one kernel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/depth_map.h"

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec DepthMap::accept(const ImageSpec& in) {
  require(in, Pixel::disparity16, "the disparity");
  scratch_.resize(kernels::depth_scratch(in.width, in.height));
  return {Pixel::count16, 0, in.width, static_cast<uint16_t>(config_.census.width)};
}

bool DepthMap::filter(const Image& in, Image& out) noexcept {
  machine_.kernels.count_depth(plane<int16_t>(in), plane<int16_t>(out), scratch_.data());
  return true;
}

}  // namespace vdisp
