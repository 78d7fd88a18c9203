// seen_through.cpp: a remembered cell is looked up in the disparities, as an obstacle of max_height would show there.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/seen_through.h"

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr double heights[] = {0.3, 0.6, 0.9};           // of max_height: whatever is an obstacle reaches higher
constexpr double across[] = {-0.3, 0, 0.3};             // of a cell
constexpr int least_farther = 3;                        // of nine: one row of them
constexpr double farther_px = 1, farther_share = 0.03;  // as Occupancy tells what is as deep as a cell

}  // namespace

SeenThrough::SeenThrough(const Config& config, const Image& disparity, const FloorModel& floor)
    : config_(config),
      disparity_(disparity),
      view_(stereo_view(disparity)),
      floor_(floor, view_),
      height_(floor.height_m),
      pitch_(floor.pitch_rad),
      roll_(floor.roll_rad),
      nearest_(nearest_matched(view_, disparity.camera.min_disparity + disparity.camera.disparities - 1)) {}

Point SeenThrough::seen_at(double right, double ahead, double above) const noexcept {
  return camera({right, height_ - floor_.elevation(ahead) - above, ahead}, pitch_, roll_);
}

bool SeenThrough::too_near(double right, double ahead) const noexcept {
  return seen_at(right, ahead - config_.map.cell / 2, config_.limit.max_height).z < nearest_;
}

int SeenThrough::bin(double column) const noexcept {
  return static_cast<int>(std::clamp(column * bins / disparity_.spec.width, 0.0, bins - 1.0));
}

void SeenThrough::hide_behind(double right, double ahead) noexcept {
  const Point at = seen_at(right, ahead, config_.limit.max_height);
  const double least = 0.1;  // m: nearer, or behind, it is in no picture
  if (at.z < least) return;
  const double middle = view_.cx + view_.f * at.x / at.z, half = view_.f * config_.map.cell / 2 / at.z;
  if (middle + half < 0 || middle - half >= disparity_.spec.width) return;
  for (int i = bin(middle - half); i <= bin(middle + half); ++i) hidden_.set(static_cast<size_t>(i));
}

bool SeenThrough::hidden(double right, double ahead) const noexcept {
  if (hidden_.none()) return false;
  const Point at = seen_at(right, ahead, 0);
  return at.z > 0 && hidden_.test(static_cast<size_t>(bin(view_.cx + view_.f * at.x / at.z)));
}

bool SeenThrough::passed(double right, double ahead) const noexcept {
  int farther = 0;
  for (const double part : heights) {
    const Point middle = seen_at(right, ahead, part * config_.limit.max_height);
    if (middle.z < nearest_) return false;
    const double d = view_.f * view_.baseline / middle.z;
    const double least = 16 * ((1 - farther_share) * d - farther_px + view_.cx_offset);
    const int v = static_cast<int>(std::lround(view_.cy + view_.f * middle.y / middle.z));
    if (v < 0 || v >= disparity_.spec.height) continue;
    for (const double aside : across) {
      const int u = static_cast<int>(std::lround(view_.cx + view_.f * (middle.x + aside * config_.map.cell) / middle.z));
      if (u < 0 || u >= disparity_.spec.width) continue;
      const int16_t seen = disparity_.row<int16_t>(v)[u];
      if (seen <= rejected_base) continue;
      if (seen >= least) return false;
      ++farther;
    }
  }
  return farther >= least_farther;
}

}  // namespace vdisp
