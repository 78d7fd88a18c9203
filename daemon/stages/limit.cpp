// limit.cpp: the floor line, raised by max_height.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/limit.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/local_floor.h"
#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec Limit::accept(const ImageSpec& floor, const ImageSpec& model) {
  require(floor, Pixel::line16, "the floor");
  require(model, Pixel::record, "the floor model");
  return floor;
}

bool Limit::combine(const Image& floor, const Image& model_image, Image& out) noexcept {
  const FloorModel& model = *model_image.row<FloorModel>(0);
  const double pitch = pitch_in_use(config_, model);
  out.reason = no_metres(floor, pitch);
  if (out.reason != Reason::none) return false;
  const double rise = config_.limit.max_height / (static_cast<double>(floor.camera.baseline) * std::cos(pitch));
  const LocalFloor local(model, stereo_view(floor));
  int16_t* rows = out.row<int16_t>(0);
  for (int column = 0; column < out.spec.width; ++column) {
    const double d = true_disparity(floor.camera, column);
    // The largest whole row that is higher: of the exact line, not of the rows of `floor`, which are rounded.
    const double line = measures_roll(model) && d > 0 ? local.row(d, config_.limit.max_height) : 16 * model.a * d + model.b - rise * d;
    const double row = std::clamp(line, -31999.0, 32001.0);
    const int up = static_cast<int>(row) + (row > static_cast<int>(row));  // std::ceil, without a call
    rows[column] = d > 0 ? static_cast<int16_t>(up - 1) : line_none;
  }
  return true;
}

}  // namespace vdisp
