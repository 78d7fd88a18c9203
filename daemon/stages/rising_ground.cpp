// rising_ground.cpp: rows of samples from below, each sample against the ground seen last in its column.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/rising_ground.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

using kernels::Surface;
constexpr uint8_t none = static_cast<uint8_t>(Surface::none), level = static_cast<uint8_t>(Surface::floor),
                  obstacle = static_cast<uint8_t>(Surface::obstacle), ground = 255;
constexpr int columns_looked_at = 160, rows_looked_at = 120;  // of any image: every 4th in 640x480
constexpr int disparity_noise = 6;                            // 1/16 px: what may be nearer by this is taken to be
constexpr int least_apart = 2, most_apart = 6;                // samples: the noise of nearer ones is as great as what ground recedes by
constexpr float rows_of_step = 3;                             // samples that the face of a step of max_height fills, to be seen as one
constexpr float most_receding = 2;                            // times as much as level ground does: what is farther stands behind a gap
constexpr int least_beside = 5;                               // of the eight samples around: alone it is noise
constexpr int same_ground = 16;                               // 1/16 px around a sample, within which ground recedes to the next

}  // namespace

void RisingGround::prepare(const ImageSpec& disparity) {
  across_ = std::max((disparity.width + columns_looked_at / 2) / columns_looked_at, 1);
  down_ = std::max((disparity.height + rows_looked_at / 2) / rows_looked_at, 1);
  columns_ = disparity.width / across_;
  rows_ = disparity.height / down_;
  shows_.assign(static_cast<size_t>(columns_ * rows_), none);
  ground_.assign(static_cast<size_t>(columns_), Ground{});
}

void RisingGround::mark(const Image& disparity, const FloorModel& model, const kernels::HeightTables& tables,
                        std::span<Image* const> surfaces) noexcept {
  const CameraGeometry& g = disparity.camera;
  const auto real = [](double value) { return static_cast<float>(value); };
  const float fb = g.f * g.baseline, high = real(model.height_m), step = real(config_.limit.max_height);
  const Scale scale{16 * g.min_disparity,
                    fb / (1000 * high),
                    disparity_noise / (16 * fb),
                    high,
                    real(std::sin(model.pitch_rad)),
                    real(std::cos(model.pitch_rad)),
                    real(std::sin(model.roll_rad)) / g.f,
                    real(std::cos(model.roll_rad)) / g.f,
                    real(std::tan(config_.floor.maxSlope)),
                    static_cast<float>(down_) / g.f,
                    g.f * step / (rows_of_step * static_cast<float>(down_))};
  std::fill(ground_.begin(), ground_.end(), Ground{0, 0, -1});
  bool any = false;
  for (int row = 0; row < rows_; ++row) any |= climb(disparity, surfaces, tables, scale, row);
  if (!any) return;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column)
      if (shows_[static_cast<size_t>(row * columns_ + column)] == ground && among_ground(row, column))
        paint(disparity, surfaces, row, column);
  }
}

bool RisingGround::climb(const Image& disparity, std::span<const Image* const> surfaces, const kernels::HeightTables& tables,
                         const Scale& scale, int row) noexcept {
  const int v = this->v(disparity, row), step = static_cast<int>(1000 * config_.limit.max_height);
  const uint8_t* is = surfaces[1]->row<uint8_t>(v);
  const int16_t *disparities = disparity.row<int16_t>(v), *heights = surfaces[0]->row<int16_t>(v);
  const float below = (static_cast<float>(v) - disparity.camera.cy) * scale.down;
  uint8_t* shows = &shows_[static_cast<size_t>(row * columns_)];
  bool any = false;
  for (int column = 0; column < columns_; ++column) {
    Ground& last = ground_[static_cast<size_t>(column)];
    shows[column] = is[u(column)];
    if (shows[column] == none) continue;
    // What is an obstacle for another reason than its height stays one.
    if (shows[column] != level && (shows[column] != obstacle || heights[u(column)] < step)) {
      last.row = -1;
      continue;
    }
    const bool begins = last.row < 0;
    if (begins ? shows[column] == obstacle : shows[column] == level && row - last.row < least_apart) continue;
    const float* inverse = &tables.inverse[disparities[u(column)] - scale.first];
    const float slope = below + (static_cast<float>(u(column)) - disparity.camera.cx) * scale.across;
    const float on_a_metre = scale.cos_pitch - slope * scale.sin_pitch, down_a_metre = scale.sin_pitch + slope * scale.cos_pitch;
    const float z = inverse[0] * scale.depth, nearest = inverse[disparity_noise] * scale.depth;
    const float on = nearest * on_a_metre - last.ahead, up = scale.height - nearest * down_a_metre - last.up;
    if (shows[column] == obstacle) {
      if (z > scale.farthest || !leads_on(last, scale, on, up, 2 * scale.noise * z * z, row - last.row)) {
        last.row = -1;
        continue;
      }
      shows[column] = ground;
      any = true;
    }
    const bool recedes = on > 0 && up <= scale.steepest * on;
    if (begins || (recedes && row - last.row >= least_apart)) last = {z * on_a_metre, scale.height - z * down_a_metre, row};
  }
  return any;
}

bool RisingGround::leads_on(const Ground& ground, const Scale& scale, float on, float up, float vague, int rows) const noexcept {
  if (rows > most_apart) return false;
  const float step = static_cast<float>(config_.limit.max_height);
  if (on > 0 && up <= scale.steepest * on) {
    // Level ground recedes by z^2 / (f high) from row to row. What is a gap farther stands behind the brow, wherever its foot is.
    const float high = std::max(scale.height - ground.up, step), receding = scale.recedes * ground.ahead * ground.ahead / high;
    return on <= most_receding * receding * static_cast<float>(rows) + vague;
  }
  return up <= step && on <= step + vague;
}

bool RisingGround::among_ground(int row, int column) const noexcept {
  int beside = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c) {
      const uint8_t is = shows_[static_cast<size_t>(r * columns_ + c)];
      beside += is == ground || is == level;
    }
  }
  return beside > least_beside;  // itself is one
}

void RisingGround::paint(const Image& disparity, std::span<Image* const> surfaces, int row, int column) const noexcept {
  const int step = static_cast<int>(1000 * config_.limit.max_height);
  const int middle = v(disparity, row), here = disparity.row<int16_t>(middle)[u(column)];
  for (int v = std::max(middle - down_, 0); v <= std::min(middle + down_, disparity.spec.height - 1); ++v) {
    const int16_t *d = disparity.row<int16_t>(v), *height = surfaces[0]->row<int16_t>(v);
    uint8_t* is = surfaces[1]->row<uint8_t>(v);
    int16_t* stands = surfaces[2]->row<int16_t>(v);
    for (int u = std::max(column - 1, 0) * across_; u < std::min(column + 2, columns_) * across_; ++u) {
      if (is[u] != obstacle || height[u] < step || std::abs(d[u] - here) > same_ground) continue;
      is[u] = level;
      stands[u] = rejected(Rejected::matcher);
    }
  }
}

}  // namespace vdisp
