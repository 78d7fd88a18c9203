// vdisparity.cpp: algorithm 1 of the paper.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/vdisparity.h"

#include <cstring>

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec VDisparity::accept(const ImageSpec& in) {
  require(in, Pixel::disparity16, "the input");
  return {Pixel::count16, 0, static_cast<uint16_t>(16 * config_.image_source.ndisp), in.height};
}

bool VDisparity::filter(const Image& in, Image& out) noexcept {
  for (int v = 0; v < in.spec.height; ++v) {
    const int16_t* disparity = in.row<int16_t>(v);
    int16_t* votes = out.row<int16_t>(v);
    std::memset(votes, 0, out.spec.stride());
    for (int u = 0; u < in.spec.width; ++u) {
      const int column = vdisparity_column(in.camera, disparity[u]);
      if (column >= 0 && votes[column] < INT16_MAX) ++votes[column];
    }
  }
  return true;
}

}  // namespace vdisp
