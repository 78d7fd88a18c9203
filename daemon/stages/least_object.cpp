// least_object.cpp: part of `occupancy`: how many pixels the least object that counts has in the picture.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr double object_of_step = 0.5;  // the least object is this part of max_height higher than max_height
constexpr double least_part = 0.15;     // of the least object, that is taken to be inside the picture

}  // namespace

double Occupancy::least_object(const Inputs& in, const Box& box) const noexcept {
  const double per_metre = (box.d_far + box.d_near) / 2 / in.view.baseline;  // px
  return object_of_step * config_.limit.max_height * per_metre * config_.map.cell * per_metre;
}

double Occupancy::part_in_view(const Inputs& in, const Box& box) const noexcept {
  const double per_metre = (box.d_far + box.d_near) / 2 / in.view.baseline;  // px
  const double step = config_.limit.max_height * per_metre, tall = object_of_step * step;
  const auto inside = [](double first, double last, double from, double to) {
    return std::max(std::min(last, to) - std::max(first, from), 0.0) / std::max(last - first, 1e-6);
  };
  const int reach = config_.image_source.corrsize / 2;
  const double bottom = (box.top + box.bottom) / 2 - step;
  return inside(box.left, box.right, in.disparity.camera.min_disparity + in.disparity.camera.disparities - 1 + reach,
                in.disparity.spec.width - reach) *
         inside(bottom - tall, bottom, reach, in.disparity.spec.height - reach);
}

double Occupancy::expected(const Inputs& in, const Box& box) const noexcept {
  return least_object(in, box) * std::max(part_in_view(in, box), least_part);
}

}  // namespace vdisp
