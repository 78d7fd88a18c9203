// blobs.cpp: cells are flooded, every eighth pixel or so is added to the blob whose cell it stands over.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/blobs.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int looked_at = 6000;  // pixels at most: a box of 0.3 m still has 16 at 4.5 m and 640 x 480
constexpr int least_pixels = 4;
constexpr double least_deviation = 0.02, deviation_of_range = 0.003;  // m, and per m^2: disparities err by a part of a pixel

}  // namespace

void Blobs::reserve(const ImageSpec& grid, const ImageSpec& pixels) {
  rows_ = grid.height;
  columns_ = grid.width;
  const size_t cells = static_cast<size_t>(rows_) * static_cast<size_t>(columns_);
  labels_.assign(cells, 0);
  open_.assign(cells, 0);
  step_ = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(pixels.width) * pixels.height / looked_at))));
}

/// Numbers the obstacles' cells, neighbours at corners included; how many blobs there are.
int Blobs::label(const ObstacleImages& in) noexcept {
  std::fill(labels_.begin(), labels_.end(), uint8_t{0});
  const auto wanted = [&](int row, int column) {
    return in.occupancy.row<int8_t>(row)[column] >= occupied_from &&
           in.reason.row<uint8_t>(row)[column] == static_cast<uint8_t>(CellReason::obstacle) &&
           labels_[static_cast<size_t>(row * columns_ + column)] == 0;
  };
  int count = 0;
  // From near to far: where there are too many the far ones are left out.
  for (int row = rows_ - 1; row >= 0; --row) {
    for (int column = 0; column < columns_ && count < most; ++column) {
      if (!wanted(row, column)) continue;
      ++count;
      size_t open = 0;
      const auto put = [&](int r, int c) {
        labels_[static_cast<size_t>(r * columns_ + c)] = static_cast<uint8_t>(count);
        open_[open++] = r * columns_ + c;
      };
      put(row, column);
      while (open > 0) {
        const int cell = open_[--open], r0 = cell / columns_, c0 = cell % columns_;
        for (int r = std::max(r0 - 1, 0); r <= std::min(r0 + 1, rows_ - 1); ++r) {
          for (int c = std::max(c0 - 1, 0); c <= std::min(c0 + 1, columns_ - 1); ++c)
            if (wanted(r, c)) put(r, c);
        }
      }
    }
  }
  return count;
}

void Blobs::add_pixels(const ObstacleImages& in, const Placement& placement) noexcept {
  const StereoView view = stereo_view(in.standing);
  const double cp = std::cos(in.floor.pitch_rad), sp = std::sin(in.floor.pitch_rad), cr = std::cos(in.floor.roll_rad),
               sr = std::sin(in.floor.roll_rad), fb = view.f * view.baseline;
  const CameraGeometry& g = in.standing.camera;
  const double nearest = g.min_disparity + g.disparities - 2, first_matched = g.min_disparity + g.disparities + step_;
  const double cells_per_m = 1 / static_cast<double>(in.occupancy.grid.cell), middle = columns_ / 2.0;
  for (int v = step_ / 2; v < in.standing.spec.height; v += step_) {
    const int16_t* disparities = in.standing.row<int16_t>(v);
    const int16_t* heights = in.height.row<int16_t>(v);
    for (int u = step_ / 2; u < in.standing.spec.width; u += step_) {
      const double d = disparities[u] / 16.0, true_d = d - view.cx_offset;
      if (disparities[u] <= rejected_base || true_d <= 0) continue;
      const double z = fb / true_d, x = (u - view.cx) * z / view.f, y = (v - view.cy) * z / view.f;
      const double right = x * cr - y * sr, ahead = z * cp - (x * sr + y * cr) * sp;
      const double from_near = ahead * cells_per_m, from_left = right * cells_per_m + middle;
      if (from_near < 0 || from_near >= rows_ || from_left < 0 || from_left >= columns_) continue;
      const int row = rows_ - 1 - static_cast<int>(from_near), column = static_cast<int>(from_left);
      const uint8_t number = labels_[static_cast<size_t>(row * columns_ + column)];
      if (number == 0) continue;
      const OnGround at = placement.outside(right, ahead);
      Sum& sum = sums_[number];
      const bool first = sum.pixels++ == 0;
      sum.x += at.x;
      sum.y += at.y;
      sum.ahead += ahead;
      sum.least_x = first ? at.x : std::min(sum.least_x, at.x);
      sum.most_x = first ? at.x : std::max(sum.most_x, at.x);
      sum.least_y = first ? at.y : std::min(sum.least_y, at.y);
      sum.most_y = first ? at.y : std::max(sum.most_y, at.y);
      sum.height = std::max(sum.height, heights[u] / 1000.0);
      // Left of that the right view has no match to search in; nearer than that nothing is matched; and the map ends somewhere.
      sum.cut = sum.cut || u < first_matched || u + 2 * step_ >= in.standing.spec.width || d > nearest || row < 1 || column < 1 ||
                column >= columns_ - 1;
    }
  }
}

std::span<const Blob> Blobs::find(const ObstacleImages& in, const Placement& placement) noexcept {
  const int count = label(in);
  std::fill(sums_.begin(), sums_.end(), Sum{});
  if (count > 0) add_pixels(in, placement);
  size_t kept = 0;
  for (int i = 1; i <= count; ++i) {
    const Sum& sum = sums_[static_cast<size_t>(i)];
    if (sum.pixels < least_pixels) continue;
    const double ahead = sum.ahead / sum.pixels;
    blobs_[kept++] = {sum.x / sum.pixels,
                      sum.y / sum.pixels,
                      sum.most_x - sum.least_x,
                      sum.most_y - sum.least_y,
                      sum.height,
                      least_deviation + deviation_of_range * ahead * ahead,
                      sum.cut};
  }
  return {blobs_.data(), kept};
}

}  // namespace vdisp
