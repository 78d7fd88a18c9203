// expected_floor.cpp: a plane in disparity space, from a floor line or from the mounting.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/expected_floor.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr uint64_t held_frames = 30;  // a floor not seen for longer is not expected any more

}  // namespace

kernels::RowDisparity ExpectedFloor::row(int row) const {
  constexpr double unit = 16.0 * 65536.0;
  return {std::llround(unit * (at_row(row) + cx_offset - tilt * cx)), std::llround(unit * tilt)};
}

int ExpectedFloor::first_row(int width) const {
  const double left = tilt * cx, right = -tilt * (width - 1 - cx);
  return static_cast<int>(std::clamp(std::ceil(row0 + std::min({left, right, 0.0}) / slope), 0.0, 32767.0));
}

std::optional<ExpectedFloor> FloorExpectation::expect(const Image& view, const FloorModel* last) noexcept {
  const std::optional<ExpectedFloor> mounted = from_mounting(view);
  if (last && last->state != FloorState::lost && last->a > 0 && !(mounted && last->mounting_differs)) {
    const double slope = 1 / (16 * last->a), roll = std::isnan(last->roll_rad) ? config_.mounting.roll : last->roll_rad;
    last_found_ = ExpectedFloor{slope, last->b, slope * std::tan(roll), static_cast<double>(view.camera.cx),
                                static_cast<double>(view.camera.cx_offset)};
    last_sequence_ = view.sequence;
    return last_found_;
  }
  if (mounted) return mounted;
  if (last_found_ && view.sequence - last_sequence_ <= held_frames) return last_found_;
  return std::nullopt;
}

std::optional<ExpectedFloor> FloorExpectation::from_mounting(const Image& view) const noexcept {
  const StereoView stereo = stereo_view(view);
  const double height = config_.mounting.height, pitch = config_.expected_pitch();
  if (!stereo.calibrated() || height <= 0 || std::isnan(pitch)) return std::nullopt;
  const FloorLine line = floor_line(stereo, height, pitch);
  return ExpectedFloor{1 / line.slope, line.row0, std::tan(config_.mounting.roll) / line.slope, stereo.cx, stereo.cx_offset};
}

}  // namespace vdisp
