// expected_floor.cpp: a plane in disparity space, from a floor line or from the mounting.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/expected_floor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/geometry/floor_plane.h"
#include "daemon/stages/local_floor.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr double slope_over = 0.5;          // m: of the ground last seen
constexpr float hidden = -1e4f;             // px: no floor there
constexpr uint64_t held_frames = 30;        // a floor not seen for longer is not expected any more
constexpr double most_turn = 0.06;          // rad from one frame to the next: what turns faster is another floor
constexpr int64_t longest_ns = 70'000'000;  // from frame to frame: a rover that nods twice a second turns back in 80 ms, or may
constexpr int64_t most_ahead = 2;           // times as long as the turn was measured over

}  // namespace

kernels::RowDisparity ExpectedFloor::row(int row) const {
  constexpr double unit = 16.0 * 65536.0;
  return {std::llround(unit * (at_row(row) + cx_offset - tilt * cx)), std::llround(unit * tilt)};
}

int ExpectedFloor::first_row(int width) const {
  const double left = tilt * cx, right = -tilt * (width - 1 - cx);
  if (!bent.empty()) {
    const double least = std::min({left, right, 0.0});
    return static_cast<int>(std::find_if(bent.begin(), bent.end(), [&](float d) { return d >= least; }) - bent.begin());
  }
  return static_cast<int>(std::clamp(std::ceil(row0 + std::min({left, right, 0.0}) / slope), 0.0, 32767.0));
}

std::optional<ExpectedFloor> FloorExpectation::expect(const Image& view, const FloorModel* last) noexcept {
  const std::optional<ExpectedFloor> mounted = from_mounting(view);
  const double turned = turn(view, last);
  if (last && last->state != FloorState::lost && last->a > 0 && !(mounted && contradicts(*last))) {
    const double slope = 1 / (16 * last->a), roll = std::isnan(last->roll_rad) ? config_.mounting.roll : last->roll_rad;
    last_found_ = ExpectedFloor{slope, last->b, slope * std::tan(roll), static_cast<double>(view.camera.cx),
                                static_cast<double>(view.camera.cx_offset)};
    if (turned != 0) {
      const double pitch = last->pitch_rad + turned, faces = std::cos(pitch) / std::cos(last->pitch_rad);
      last_found_->row0 -= static_cast<double>(view.camera.f) * (std::tan(pitch) - std::tan(last->pitch_rad));
      last_found_->slope *= faces;
      last_found_->tilt *= faces;
    }
    if (last->profile_count > 1) bend(view, *last, last->pitch_rad + turned, *last_found_);
    last_sequence_ = view.sequence;
    return last_found_;
  }
  if (mounted) return mounted;
  if (last_found_ && view.sequence - last_sequence_ <= held_frames) return last_found_;
  return std::nullopt;
}

/// By how much the camera pitches until this frame, if it goes on as from the last floor but one to the last, rad. A rover that bumps along
/// at 30 frames a second pitches by a degree or two from one to the next: far ahead, more than half a window.
double FloorExpectation::turn(const Image& view, const FloorModel* last) noexcept {
  if (view.timestamp_ns == pitched_.frame_ns) return 0;  // a second look
  const double pitch = last && last->state == FloorState::found ? last->pitch_rad : NAN;
  const Pitched before = std::exchange(pitched_, {view.timestamp_ns, pitched_.frame_ns, pitch});
  const int64_t since = view.timestamp_ns - before.frame_ns, then = before.frame_ns - before.floor_ns;
  if (since <= 0 || since > longest_ns || since > most_ahead * then || then > longest_ns || !(std::abs(pitch - before.pitch) < most_turn))
    return 0;
  return std::clamp((pitch - before.pitch) * static_cast<double>(since) / static_cast<double>(then), -most_turn, most_turn);
}

bool FloorExpectation::doubtful(const Image& view) noexcept {
  if (last_found_ && last_sequence_ == view.sequence) return false;
  if (doubted_ && view.sequence - *doubted_ < held_frames && from_mounting(view)) return false;
  doubted_ = view.sequence;
  return true;
}

/// A rover that comes to a ramp sees little else, and the ramp is its floor: as steep as [Floor] maxSlope, and about as far below. The
/// paper's line has no such sense: what it takes for the floor may be a wall.
bool FloorExpectation::contradicts(const FloorModel& last) const noexcept {
  if (!last.mounting_differs) return false;
  if (last.model == FloorKind::line) return true;
  const double height = config_.mounting.height, slope = last.pitch_rad - config_.expected_pitch();
  const HeightRange ramp = height_over_ramp(slope);
  return std::abs(slope) > config_.floor.maxSlope || last.height_m < ramp.least * height || last.height_m > ramp.most * height;
}

/// From row to row upwards, along the profile; where what lies ahead is hidden by a crest, on to what is seen behind it. Beyond what was
/// seen the ground is expected to rise or fall on as it did: where it does not, nothing will match so.
void FloorExpectation::bend(const Image& view, const FloorModel& last, double pitch, ExpectedFloor& floor) noexcept {
  struct Knot {
    double row, disparity;
  };
  const StereoView stereo = stereo_view(view);
  const LocalFloor local(last, stereo);
  const auto see = [&](double ahead, double elevation) {
    const Point p = camera({0, last.height_m - elevation, ahead}, pitch);
    const double z = std::max(p.z, 0.01);
    return Knot{stereo.cy + stereo.f * p.y / z, stereo.f * stereo.baseline / z};
  };
  int row = static_cast<int>(bent_.size()) - 1;
  const auto fill = [&](const Knot& near, const Knot& far, int first) {
    for (; row >= std::max(first, 0) && far.row < near.row; --row)
      bent_[static_cast<size_t>(row)] =
          static_cast<float>(near.disparity + (row - near.row) * (far.disparity - near.disparity) / (far.row - near.row));
  };
  const double start = static_cast<double>(last.profile_start_m), step = static_cast<double>(last.profile_step_m);
  const double begin = local.elevation(start);
  Knot before = see(start, begin);
  fill(before, see(start + step, begin), static_cast<int>(std::ceil(before.row)));
  const int seen = static_cast<int>(std::min({last.profile_seen, last.profile_count, FloorModel::profile_capacity}));
  double ahead = start;
  for (int i = 1; i < seen; ++i) {
    ahead = start + i * step;
    const Knot next = see(ahead, local.elevation(ahead));
    fill(before, next, static_cast<int>(std::ceil(next.row)));
    before = next;
  }
  const double run = std::min(slope_over, ahead - start), end = local.elevation(ahead);
  const double slope = run > 0 ? (end - local.elevation(ahead - run)) / run : 0;
  fill(before, see(ahead + step, end + slope * step), 0);
  for (; row >= 0; --row) bent_[static_cast<size_t>(row)] = hidden;
  floor.bent = bent_;
}

std::optional<ExpectedFloor> FloorExpectation::from_mounting(const Image& view) const noexcept {
  const StereoView stereo = stereo_view(view);
  const double height = config_.mounting.height, pitch = config_.expected_pitch();
  if (!stereo.calibrated() || height <= 0 || std::isnan(pitch)) return std::nullopt;
  const FloorLine line = floor_line(stereo, height, pitch);
  return ExpectedFloor{1 / line.slope, line.row0, std::tan(config_.mounting.roll) / line.slope, stereo.cx, stereo.cx_offset};
}

}  // namespace vdisp
