// rising_ground.cpp: samples of a column of the image from below, each against the ground seen last.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/rising_ground.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/limits_mm.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int columns_looked_at = 160, rows_looked_at = 120;  // of any image: every 4th in 640x480
constexpr int disparity_noise = 6;                            // 1/16 px: what may be nearer by this is taken to be
constexpr int least_apart = 2, most_apart = 6;                // samples: the noise of nearer ones is as great as what ground recedes by
constexpr int lead_in = 8;                                    // samples of floor before what is higher
constexpr int samples_of_step = 3;                            // that the face of a step of max_height fills, to be seen as one
constexpr float most_receding = 1.6f;                         // times as much as level ground does: what is farther stands behind a gap
constexpr int least_beside = 5;                               // of the eight samples around: alone it is noise
constexpr double steepest_told = 0.35;                        // rad: a step hardly higher than max_height is as steep, far off
constexpr int off_line = 16;     // 1/16 px: what is farther off the line between two samples of ground stands there
constexpr int same_ground = 16;  // 1/16 px around a sample, within which ground recedes to the next

}  // namespace

void RisingGround::prepare(const ImageSpec& disparity) {
  across_ = std::max((disparity.width + columns_looked_at / 2) / columns_looked_at, 1);
  down_ = std::max((disparity.height + rows_looked_at / 2) / rows_looked_at, 1);
  columns_ = disparity.width / across_;
  rows_ = disparity.height / down_;
  shows_.assign(static_cast<size_t>(columns_ * rows_), Shows::nothing);
  higher_from_.assign(static_cast<size_t>(columns_), rows_);
}

void RisingGround::mark(const Image& disparity, const FloorModel& model, const kernels::HeightTable& table,
                        std::span<Image* const> surfaces) noexcept {
  step_mm_ = LimitsMm(config_).step;
  std::fill(higher_from_.begin(), higher_from_.end(), rows_);
  for (int row = 0; row < rows_; ++row) gather(disparity, surfaces, row);
  const CameraGeometry& g = disparity.camera;
  const auto real = [](double value) { return static_cast<float>(value); };
  const float fb = g.f * g.baseline, high = real(model.height_m), step = real(config_.limit.max_height);
  const float face = static_cast<float>(std::max(samples_of_step * down_, config_.image_source.corrsize + 1));
  const Scale scale{table,
                    16 * g.min_disparity,
                    fb / (1000 * high),
                    disparity_noise / (16 * fb),
                    high,
                    real(std::sin(model.pitch_rad)),
                    real(std::cos(model.pitch_rad)),
                    real(std::sin(model.roll_rad)) / g.f,
                    real(std::cos(model.roll_rad)) / g.f,
                    real(std::tan(std::min<double>(config_.floor.maxSlope, steepest_told))),
                    static_cast<float>(down_) / g.f,
                    g.f * step / face};
  bool any = false;
  for (int column = 0; column < columns_; ++column)
    if (higher_from_[static_cast<size_t>(column)] < rows_) any |= climb(disparity, scale, column);
  for (int row = 0; any && row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column)
      if (shows(row, column) == Shows::ground && among_ground(row, column)) paint(disparity, surfaces, row, column);
  }
}

void RisingGround::gather(const Image& disparity, std::span<const Image* const> surfaces, int row) noexcept {
  using kernels::Surface;
  const int line = row_of(disparity, row);
  const uint8_t* is = surfaces[1]->row<uint8_t>(line);
  const int16_t* heights = surfaces[0]->row<int16_t>(line);
  Shows* shows = &shows_[static_cast<size_t>(row * columns_)];
  for (int column = 0; column < columns_; ++column) {
    const auto surface = static_cast<Surface>(is[column_of(column)]);
    shows[column] = surface == Surface::none ? Shows::nothing : surface == Surface::floor ? Shows::floor : Shows::other;
    // What is an obstacle for another reason than its height stays one.
    if (surface != Surface::obstacle || heights[column_of(column)] < step_mm_) continue;
    shows[column] = Shows::higher;
    higher_from_[static_cast<size_t>(column)] = std::min(higher_from_[static_cast<size_t>(column)], row);
  }
}

bool RisingGround::climb(const Image& disparity, const Scale& scale, int column) noexcept {
  bool any = false;
  Ground last{};
  for (int row = std::max(higher_from_[static_cast<size_t>(column)] - lead_in, 0); row < rows_; ++row) {
    const Shows here = shows(row, column);
    if (here == Shows::nothing) continue;
    const int apart = row - last.row;
    if (here == Shows::other || (last.row < 0 && here == Shows::higher)) {
      last.row = -1;
      continue;
    }
    if (last.row >= 0 && here == Shows::floor && apart < least_apart) continue;
    const Sample sample = look(disparity, scale, row, column);
    const float on = sample.nearest.ahead - last.ahead, up = sample.nearest.up - last.up;
    const bool goes_on = last.row >= 0 && apart <= most_apart && on >= -sample.vague && on <= reach(scale, last, apart);
    const bool recedes = goes_on && apart >= least_apart && on > 0 && up <= scale.steepest * on;
    const Ground next{sample.ahead, sample.up, sample.disparity, row, recedes};
    if (!goes_on || (here == Shows::higher && sample.depth > scale.farthest) ||
        (recedes && stands_between(disparity, last, next, column))) {
      last = here == Shows::floor ? Ground{sample.ahead, sample.up, sample.disparity, row, false} : Ground{};
    } else if (recedes) {
      any |= join(last, next, column);
      last = next;
    } else if (here == Shows::higher && last.recedes && apart * down_ <= config_.image_source.corrsize / 2 + 1) {
      // The window of the matcher gives its rim the disparity of the rim.
      shows(row, column) = Shows::ground;
      any = true;
    }
  }
  return any;
}

RisingGround::Sample RisingGround::look(const Image& disparity, const Scale& scale, int row, int column) const noexcept {
  const int u = column_of(column), v = row_of(disparity, row);
  const int16_t d = disparity.row<int16_t>(v)[u];
  const float slope =
      (static_cast<float>(u) - disparity.camera.cx) * scale.across + (static_cast<float>(v) - disparity.camera.cy) * scale.down;
  const float on_a_metre = scale.cos_pitch - slope * scale.sin_pitch, down_a_metre = scale.sin_pitch + slope * scale.cos_pitch;
  const int at = d - scale.first;
  const float z = scale.table[at].inverse * scale.depth, nearest = scale.table[at + disparity_noise].inverse * scale.depth;
  return {z * on_a_metre,
          scale.height - z * down_a_metre,
          z,
          2 * scale.noise * z * z,
          {nearest * on_a_metre, scale.height - nearest * down_a_metre},
          d};
}

/// Level ground recedes by z^2 / (f high) from row to row. What is a gap farther stands behind the brow, wherever its foot is.
float RisingGround::reach(const Scale& scale, const Ground& from, int rows_on) const noexcept {
  const float high = std::max(scale.height - from.up, static_cast<float>(config_.limit.max_height));
  return most_receding * scale.recedes * from.ahead * from.ahead / high * static_cast<float>(rows_on);
}

/// Between two samples of ground lies ground, on their line: disparities of a plane are linear in the row. What is off it is the face of
/// something, or stands behind a brow.
bool RisingGround::stands_between(const Image& disparity, const Ground& from, const Ground& to, int column) const noexcept {
  const int rows = to.row - from.row;
  for (int row = from.row + 1; row < to.row; ++row) {
    if (shows(row, column) != Shows::higher) continue;
    const int d = disparity.row<int16_t>(row_of(disparity, row))[column_of(column)];
    if (std::abs((d - from.disparity) * rows - (to.disparity - from.disparity) * (row - from.row)) > off_line * rows) return true;
  }
  return false;
}

bool RisingGround::join(const Ground& from, const Ground& to, int column) noexcept {
  bool any = false;
  for (int row = from.row + 1; row <= to.row; ++row) {
    if (shows(row, column) != Shows::higher) continue;
    shows(row, column) = Shows::ground;
    any = true;
  }
  return any;
}

bool RisingGround::among_ground(int row, int column) const noexcept {
  int beside = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c)
      beside += shows(r, c) == Shows::ground || shows(r, c) == Shows::floor;
  }
  return beside > least_beside;  // itself is one
}

/// Its own pixels, and those towards a sample that is none.
void RisingGround::paint(const Image& disparity, std::span<Image* const> surfaces, int row, int column) const noexcept {
  using kernels::Surface;
  const auto is_ground = [&](int r, int c) { return r >= 0 && r < rows_ && c >= 0 && c < columns_ && shows(r, c) == Shows::ground; };
  const int middle = row_of(disparity, row), here = disparity.row<int16_t>(middle)[column_of(column)];
  const int top = middle - (is_ground(row + 1, column) ? down_ / 2 : down_),
            bottom = middle + (is_ground(row - 1, column) ? (down_ - 1) / 2 : down_);
  const int left = (column - !is_ground(row, column - 1)) * across_, right = (column + 1 + !is_ground(row, column + 1)) * across_;
  for (int v = std::max(top, 0); v <= std::min(bottom, disparity.spec.height - 1); ++v) {
    const int16_t *d = disparity.row<int16_t>(v), *height = surfaces[0]->row<int16_t>(v);
    uint8_t* is = surfaces[1]->row<uint8_t>(v);
    int16_t* stands = surfaces[2]->row<int16_t>(v);
    for (int u = std::max(left, 0); u < std::min<int>(right, disparity.spec.width); ++u) {
      if (static_cast<Surface>(is[u]) != Surface::obstacle || height[u] < step_mm_ || std::abs(d[u] - here) > same_ground) continue;
      is[u] = static_cast<uint8_t>(Surface::floor);
      stands[u] = rejected(Rejected::matcher);
    }
  }
}

}  // namespace vdisp
