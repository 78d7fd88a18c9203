// texture.cpp: gravel, planks, bricks, stone and bark from band-limited noise.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/texture.h"

#include <algorithm>
#include <cmath>

#include "daemon/sim/chance.h"

namespace vdisp::sim {
namespace {

constexpr int size = Textures::size;
using Field = std::vector<float>;

/// Adds smooth noise with one value per cell of cell_x by cell_y texels, in -amplitude..amplitude.
void add_noise(Field& field, int cell_x, int cell_y, float amplitude, uint32_t seed) {
  const int columns = size / cell_x, rows = size / cell_y;
  std::vector<float> lattice(static_cast<size_t>(columns) * rows);
  for (size_t i = 0; i < lattice.size(); ++i)
    lattice[i] = amplitude * (static_cast<float>(scramble(static_cast<uint32_t>(i) * 0x9e3779b9u + scramble(seed)) >> 8) * 0x1p-23f - 1);
  const auto ease = [](float t) { return t * t * (3 - 2 * t); };
  std::vector<float> line(static_cast<size_t>(columns) + 1);
  for (int y = 0; y < size; ++y) {
    const float fy = ease((static_cast<float>(y % cell_y) + 0.5f) / static_cast<float>(cell_y));
    const float* upper = &lattice[static_cast<size_t>(y / cell_y) * columns];
    const float* lower = &lattice[static_cast<size_t>((y / cell_y + 1) % rows) * columns];
    for (int i = 0; i < columns; ++i) line[i] = upper[i] + (lower[i] - upper[i]) * fy;
    line[columns] = line[0];
    float* row = &field[static_cast<size_t>(y) * size];
    for (int x = 0; x < size; ++x) {
      const int i = x / cell_x;
      row[x] += line[i] + (line[i + 1] - line[i]) * ease((static_cast<float>(x % cell_x) + 0.5f) / static_cast<float>(cell_x));
    }
  }
}

/// Noise of the same strength at each scale, as stone and soil have it; or weaker by `fading` from each scale to the next
/// coarser.
Field fractal(int finest, int coarsest, uint32_t seed, int stretch_x = 1, int stretch_y = 1, float fading = 1) {
  Field field(static_cast<size_t>(size) * size, 0.0f);
  float strength = 1;
  for (int cell = finest; cell <= coarsest; cell *= 2, strength *= fading)
    add_noise(field, std::min(size / 2, cell * stretch_x), std::min(size / 2, cell * stretch_y), strength,
              seed * 31 + static_cast<uint32_t>(cell));
  return field;
}

/// Mean 0, and `deviation` as the standard deviation.
void level(Field& field, float deviation) {
  double sum = 0, squares = 0;
  for (float value : field) {
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double n = static_cast<double>(field.size()), mean = sum / n, spread = std::sqrt(std::max(1e-12, squares / n - mean * mean));
  for (float& value : field) value = static_cast<float>((value - mean) / spread) * deviation;
}

/// Darkens the joints between stones of width x height texels, each course shifted by half, each stone of its own brightness.
void add_joints(Field& field, int width, int height, int joint, float depth, float variety, uint32_t seed, bool shifted) {
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const int course = y / height, along = (x + (shifted && course % 2 ? width / 2 : 0)) % size, stone = along / width;
      const int edge = std::min({along % width, width - 1 - along % width, y % height, height - 1 - y % height});
      const uint32_t own = scramble(seed + static_cast<uint32_t>(course * 131 + stone));
      float& value = field[static_cast<size_t>(y) * size + x];
      value += variety * (static_cast<float>(own >> 8) * 0x1p-23f - 1);
      if (edge < joint) value -= depth * (1 - static_cast<float>(edge) / static_cast<float>(joint));
    }
  }
}

/// Squares of two shades with joints, each like the next but one, and next to no grain: what a matcher takes for its neighbour.
Field mosaic(uint32_t seed) {
  constexpr int tile = 16, joint = 2;
  Field field = fractal(2, 4, seed);
  level(field, 0.02f);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const bool between = x % tile < joint || y % tile < joint;
      field[static_cast<size_t>(y) * size + x] += between ? -0.5f : (x / tile + y / tile) % 2 ? 0.25f : -0.2f;
    }
  }
  return field;
}

Field surface(Surface which, uint32_t seed) {
  Field field;
  switch (which) {
    case Surface::gravel: field = fractal(2, 64, seed, 1, 1, 0.85f); break;
    case Surface::planks:
      field = fractal(2, 32, seed, 4, 1);
      level(field, 0.20f);
      for (const Field grit = fractal(2, 16, seed + 9); float& value : field)
        value += 0.07f * grit[static_cast<size_t>(&value - field.data())];
      add_joints(field, size, 64, 5, 0.6f, 0.15f, seed, false);
      break;
    case Surface::bricks:
      field = fractal(2, 32, seed);
      level(field, 0.16f);
      add_joints(field, 128, 64, 7, 0.45f, 0.25f, seed, true);
      break;
    case Surface::stone: field = fractal(2, 128, seed); break;
    case Surface::bark:
      field = fractal(2, 32, seed, 1, 4);
      level(field, 0.25f);
      for (const Field rings = fractal(4, 32, seed + 5); float& value : field)
        value += 0.1f * rings[static_cast<size_t>(&value - field.data())];
      break;
  }
  level(field, 0.28f);
  return field;
}

}  // namespace

std::vector<uint32_t> pack(const std::vector<uint8_t>& values, int side, bool repeats) {
  std::vector<uint32_t> words(values.size());
  const auto next = [&](int i) { return i + 1 < side ? i + 1 : repeats ? 0 : side - 1; };
  for (int y = 0; y < side; ++y) {
    const uint8_t* upper = &values[static_cast<size_t>(y) * side];
    const uint8_t* lower = &values[static_cast<size_t>(next(y)) * side];
    for (int x = 0; x < side; ++x)
      words[static_cast<size_t>(y) * side + x] =
          static_cast<uint32_t>(upper[x] | upper[next(x)] << 8 | lower[x] << 16 | lower[next(x)] << 24);
  }
  return words;
}

Textures make_textures(uint32_t seed, bool tiled) {
  Textures textures;
  textures.texels.reserve(static_cast<size_t>(Textures::words) * surface_count);
  for (int which = 0; which < surface_count; ++which) {
    const uint32_t own = scramble(seed) + static_cast<uint32_t>(which) * 7919u;
    const bool tiles = tiled && static_cast<Surface>(which) == Surface::gravel;
    Field field = tiles ? mosaic(own) : surface(static_cast<Surface>(which), own);
    for (int side = size; side >= 1; side /= 2) {
      std::vector<uint8_t> values(static_cast<size_t>(side) * side);
      for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<uint8_t>(std::clamp(127.5f * (1 + field[i]) + 0.5f, 0.0f, 255.0f));
      const std::vector<uint32_t> words = pack(values, side, true);
      textures.texels.insert(textures.texels.end(), words.begin(), words.end());
      const int half = side / 2;
      for (int y = 0; y < half; ++y) {
        for (int x = 0; x < half; ++x) {
          const float* from = &field[static_cast<size_t>(2 * y) * side + 2 * x];
          field[static_cast<size_t>(y) * half + x] = (from[0] + from[1] + from[side] + from[side + 1]) / 4;
        }
      }
    }
  }
  return textures;
}

}  // namespace vdisp::sim
