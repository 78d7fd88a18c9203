// height.cpp: rows above the floor line, in mm.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/height.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec Height::accept(const ImageSpec& disparity, const ImageSpec& model) {
  require(disparity, Pixel::disparity16, "the disparity");
  require(model, Pixel::record, "the floor model");
  return {Pixel::height16, 0, disparity.width, disparity.height};
}

bool Height::combine(const Image& disparity, const Image& model_image, Image& out) noexcept {
  const FloorModel& model = *model_image.row<FloorModel>(0);
  const double pitch = pitch_in_use(config_, model);
  out.reason = no_metres(disparity, pitch);
  if (out.reason != Reason::none) return false;
  const CameraGeometry& g = disparity.camera;
  const kernels::Search search = search_of(g, 16 * g.disparities);
  const double mm_per_row = 1000 * static_cast<double>(g.baseline) * std::cos(pitch);  // times 1 / d'
  for (int v = 0; v < out.spec.height; ++v) {
    const int16_t* d = disparity.row<int16_t>(v);
    int16_t* height = out.row<int16_t>(v);
    for (int u = 0; u < out.spec.width; ++u) {
      if (!search.counts(d[u])) {
        height[u] = height_unknown;
        continue;
      }
      const double true_d = true_disparity(g, d[u] - search.first);
      const double mm = mm_per_row * (16 * model.a * true_d + model.b - v) / true_d;
      height[u] = static_cast<int16_t>(std::lround(std::clamp(mm, -32000.0, 32000.0)));
    }
  }
  return true;
}

}  // namespace vdisp
