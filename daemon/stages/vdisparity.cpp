// vdisparity.cpp: algorithm 1 of the paper.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/vdisparity.h"

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec VDisparity::accept(const ImageSpec& in) {
  require(in, Pixel::disparity16, "the input");
  scratch_.resize(kernels::vote_scratch(in.width));
  return {Pixel::count16, 0, static_cast<uint16_t>(16 * config_.image_source.ndisp), in.height};
}

bool VDisparity::filter(const Image& in, Image& out) noexcept {
  const kernels::Search search = search_of(in.camera, out.spec.width);
  machine_.kernels.count_votes(plane<int16_t>(in), 0, in.spec.height, search, plane<int16_t>(out), scratch_.data());
  return true;
}

}  // namespace vdisp
