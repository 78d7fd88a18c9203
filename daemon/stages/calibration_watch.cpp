// calibration_watch.cpp: places by turns, the best corner of each, and a verdict over some seconds.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/calibration_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/stages/row_error.h"

namespace vdisp {
namespace {

constexpr int columns = 8, rows = 6, cells = columns * rows, cells_a_frame = 10, stride = 19;  // 19 has no factor in common with 48
constexpr int most_tries = 24, compared = 3;  // pixels in a cell until so many have a disparity; the best of these is looked at
constexpr float least_strength = 16;          // gradients of 4 grey levels in every direction: three times the noise of a usual camera
constexpr int even = 4, most_uneven = 24;     // px around; 1/16 px: 1.5 px, what a floor at a flat angle has
constexpr int64_t longest_window = 20'000'000'000;  // ns
constexpr int least_points = 128, points_a_verdict = 32;
constexpr double sure = 3;     // standard deviations
constexpr double again = 0.8;  // of the limit: below it the calibration is good again

/// A disparity whose surroundings have about the same: no edge of something nearer is in the window.
bool confident(const Image& disparity, int u, int v) {
  const int16_t here = disparity.row<int16_t>(v)[u];
  if (rejected_code(here)) return false;
  for (int y : {-even, even}) {
    for (int x : {-even, even}) {
      const int16_t there = disparity.row<int16_t>(v + y)[u + x];
      if (rejected_code(there) || std::abs(there - here) > most_uneven) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<ImageSpec> CalibrationWatcher::check(std::span<const ImageSpec> in) {
  if (in.size() != 3) throw FormatError("takes the two views and their disparity, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::gray8, "the left image");
  require(in[1], Pixel::gray8, "the right image");
  require(in[2], Pixel::disparity16, "the disparity");
  require_same_size(in[0], in[1]);
  require_same_size(in[0], in[2]);
  return {record_spec<CalibrationWatch>()};
}

void CalibrationWatcher::begin_anew() noexcept {
  points_.clear();
  line_ = {};
  state_ = CalibrationState::measuring;
  drifts_ = 0;
  cell_ = unjudged_ = 0;
  chance_.seed(1);
}

void CalibrationWatcher::look_in(int cell, const Image& left, const Image& right, const Image& disparity) noexcept {
  const int width = left.spec.width, height = left.spec.height;
  const int left_edge = std::max(cell % columns * width / columns, row_error_border),
            top = std::max(cell / columns * height / rows, row_error_border);
  const int across = std::min((cell % columns + 1) * width / columns, width - row_error_border) - left_edge,
            down = std::min((cell / columns + 1) * height / rows, height - row_error_border) - top;
  if (across <= 0 || down <= 0) return;
  float strongest = least_strength;
  int u = -1, v = -1;
  for (int i = 0, seen = 0; i < most_tries && seen < compared; ++i) {
    const int x = left_edge + static_cast<int>(chance_() % static_cast<unsigned>(across)),
              y = top + static_cast<int>(chance_() % static_cast<unsigned>(down));
    if (!confident(disparity, x, y)) continue;
    ++seen;
    const float strength = corner_strength(left, x, y);
    if (strength > strongest) strongest = strength, u = x, v = y;
  }
  if (u < 0) return;
  const auto error = row_error(left, right, u, v, static_cast<float>(disparity.row<int16_t>(v)[u]) / 16);
  if (!error) return;
  const bool calibrated = left.camera.f > 0;
  const float cx = calibrated ? left.camera.cx : static_cast<float>(width) / 2,
              cy = calibrated ? left.camera.cy : static_cast<float>(height) / 2;
  points_.add({static_cast<float>(u) - cx, static_cast<float>(v) - cy, *error, left.timestamp_ns});
  ++unjudged_;
}

void CalibrationWatcher::look(const Image& left, const Image& right, const Image& disparity) noexcept {
  points_.forget_before(left.timestamp_ns - longest_window);
  for (int i = 0; i < cells_a_frame; ++i) {
    cell_ = (cell_ + stride) % cells;
    look_in(cell_, left, right, disparity);
  }
}

/// Beyond the limit where that is certain; within it again where a fifth is to spare.
void CalibrationWatcher::judge(const Image& left) noexcept {
  line_ = points_.fit();
  const double limit = config_.image_source.rowLimit, on_average = left.spec.width / 4.0;  // px from the middle
  const double shift = std::abs(line_.shift), turn = std::abs(line_.rotation) * on_average;
  const double shift_doubt = sure * line_.shift_deviation, turn_doubt = sure * line_.rotation_deviation * on_average;
  if (shift - shift_doubt > limit || turn - turn_doubt > limit || line_.median > limit) {
    if (state_ != CalibrationState::drifted) ++drifts_;
    state_ = CalibrationState::drifted;
  } else if (state_ != CalibrationState::drifted || (shift < again * limit && turn < again * limit && line_.median < again * limit)) {
    state_ = CalibrationState::good;
  }
}

Outcome CalibrationWatcher::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  look(*in[0], *in[1], *in[2]);
  if (points_.count() < least_points) {
    // What has drifted has not come back because there is little to see.
    if (state_ == CalibrationState::good) state_ = CalibrationState::measuring;
  } else if (unjudged_ >= points_a_verdict) {
    judge(*in[0]);
    unjudged_ = 0;
  }
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const bool known = state_ != CalibrationState::measuring;
  CalibrationWatch& watch = make_record<CalibrationWatch>(*out[0]);
  watch.state = state_;
  watch.points = static_cast<uint32_t>(points_.count());
  watch.window_s = static_cast<double>(in[0]->timestamp_ns - (points_.count() ? points_.oldest_ns() : in[0]->timestamp_ns)) * 1e-9;
  watch.median_px = known ? line_.median : none;
  watch.p90_px = known ? line_.p90 : none;
  watch.shift_px = known ? line_.shift : none;
  watch.shift_deviation_px = known ? line_.shift_deviation : none;
  watch.rotation_rad = known ? line_.rotation : none;
  watch.rotation_deviation_rad = known ? line_.rotation_deviation : none;
  watch.limit_px = config_.image_source.rowLimit;
  watch.drifts = drifts_;
  return Outcome::valid;
}

}  // namespace vdisp
