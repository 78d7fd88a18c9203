// row_error.cpp: a small search by squared differences, then Lucas and Kanade's steps.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/row_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace vdisp {
namespace {

constexpr int half = 5, side = 2 * half + 1, pixels = side * side;
constexpr int rows_searched = 4, columns_searched = 1;
constexpr int steps = 5;
constexpr float done = 0.01f, most_moved = 1;  // px
constexpr float most_unlike = 0.25f;           // of the variance: a correlation of some 0.87

struct Window {
  std::array<float, pixels> grey, across, down;  // brightness and its gradients, each less its mean
  float xx = 0, xy = 0, yy = 0, variance = 0;    // sums
};

void remove_mean(std::array<float, pixels>& values) {
  float sum = 0;
  for (float value : values) sum += value;
  for (float& value : values) value -= sum / pixels;
}

void take(const Image& view, int u, int v, Window& w) {
  for (int y = 0; y < side; ++y) {
    const int row = v - half + y;
    const uint8_t *here = view.row<uint8_t>(row) + u - half, *above = view.row<uint8_t>(row - 1) + u - half,
                  *below = view.row<uint8_t>(row + 1) + u - half;
    for (int x = 0; x < side; ++x) {
      const int i = y * side + x;
      w.grey[i] = here[x];
      w.across[i] = 0.5f * static_cast<float>(here[x + 1] - here[x - 1]);
      w.down[i] = 0.5f * static_cast<float>(below[x] - above[x]);
    }
  }
}

void sum_up(Window& w) {
  for (auto* values : {&w.grey, &w.across, &w.down}) remove_mean(*values);
  for (int i = 0; i < pixels; ++i) {
    w.xx += w.across[i] * w.across[i];
    w.xy += w.across[i] * w.down[i];
    w.yy += w.down[i] * w.down[i];
    w.variance += w.grey[i] * w.grey[i];
  }
}

/// Squared differences of two windows less that of their means: cameras differ in brightness. 16 columns are one vector.
int unlikeness(const Image& left, const Image& right, int u, int v, int x, int y) {
  constexpr int wide = 16;
  int sum = 0, squares = 0;
  for (int row = -half; row <= half; ++row) {
    const uint8_t *a = left.row<uint8_t>(v + row) + u - wide / 2, *b = right.row<uint8_t>(y + row) + x - wide / 2;
    for (int i = 0; i < wide; ++i) {
      const auto difference = static_cast<int16_t>(a[i] - b[i]);
      sum += difference;
      squares += difference * difference;
    }
  }
  return squares - sum * sum / (wide * side);
}

/// The right view at a fraction of a pixel, less its mean.
void sample(const Image& right, float x, float y, std::array<float, pixels>& out) {
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
  const float a = (1 - fx) * (1 - fy), b = fx * (1 - fy), c = (1 - fx) * fy, d = fx * fy;
  for (int i = 0; i < side; ++i) {
    const uint8_t *here = right.row<uint8_t>(row - half + i) + column - half,
                  *below = right.row<uint8_t>(row - half + i + 1) + column - half;
    for (int k = 0; k < side; ++k) out[i * side + k] = a * here[k] + b * here[k + 1] + c * below[k] + d * below[k + 1];
  }
  remove_mean(out);
}

}  // namespace

float corner_strength(const Image& view, int u, int v) noexcept {
  Window w;
  take(view, u, v, w);
  sum_up(w);
  const float mean = (w.xx + w.yy) / 2, apart = std::hypot((w.xx - w.yy) / 2, w.xy);
  return (mean - apart) / pixels;
}

std::optional<float> row_error(const Image& left, const Image& right, int u, int v, float disparity) noexcept {
  const int expected = static_cast<int>(std::lround(static_cast<float>(u) - disparity));
  if (expected < row_error_border || expected >= right.spec.width - row_error_border) return {};
  int best = INT32_MAX, at_x = 0, at_y = 0;
  for (int dy = -rows_searched; dy <= rows_searched; ++dy) {
    for (int dx = -columns_searched; dx <= columns_searched; ++dx) {
      const int cost = unlikeness(left, right, u, v, expected + dx, v + dy);
      if (cost < best) best = cost, at_x = dx, at_y = dy;
    }
  }
  if (std::abs(at_y) == rows_searched) return {};
  Window w;
  take(left, u, v, w);
  sum_up(w);
  const float determinant = w.xx * w.yy - w.xy * w.xy;
  if (!(determinant > 0)) return {};
  const float start_x = static_cast<float>(expected + at_x), start_y = static_cast<float>(v + at_y);
  float x = start_x, y = start_y, left_over = 0;
  std::array<float, pixels> seen;
  for (int step = 0; step < steps; ++step) {
    sample(right, x, y, seen);
    float ex = 0, ey = 0;
    left_over = 0;
    for (int i = 0; i < pixels; ++i) {
      const float off = seen[i] - w.grey[i];
      ex += off * w.across[i];
      ey += off * w.down[i];
      left_over += off * off;
    }
    const float move_x = (w.yy * ex - w.xy * ey) / determinant, move_y = (w.xx * ey - w.xy * ex) / determinant;
    x -= move_x;
    y -= move_y;
    if (!(std::abs(x - start_x) <= most_moved && std::abs(y - start_y) <= most_moved)) return {};
    if (std::abs(move_x) < done && std::abs(move_y) < done) break;
  }
  if (left_over > most_unlike * w.variance) return {};
  return y - static_cast<float>(v);
}

}  // namespace vdisp
