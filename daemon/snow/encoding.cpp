// encoding.cpp: disparity map and depth map to 80 columns and 60 rows, and their pixels to numbers.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/encoding.h"

#include <algorithm>

namespace vdisp::snow {
namespace {

using Counts = std::array<std::array<int32_t, columns>, rows>;

/// First pixel of cell i, where `pixels` of them are shared by `cells`.
int first_of(int i, int pixels, int cells) { return (i * pixels + cells - 1) / cells; }

void shrink_disparities(const Image& disparity, Image& features) noexcept {
  const int width = disparity.spec.width, height = disparity.spec.height;
  Counts sums{}, counts{};
  for (int v = 0; v < height; ++v) {
    const int16_t* row = disparity.row<int16_t>(v);
    auto& sum = sums[v * rows / height];
    auto& count = counts[v * rows / height];
    for (int x = 0; x < columns; ++x) {
      for (int u = first_of(x, width, columns), end = first_of(x + 1, width, columns); u < end; ++u) {
        const int32_t found = row[u] > 0;
        sum[x] += found * row[u];
        count[x] += found;
      }
    }
  }
  for (int y = 0; y < rows; ++y) {
    const int high = first_of(y + 1, height, rows) - first_of(y, height, rows);
    for (int x = 0; x < columns; ++x) {
      const int pixels = high * (first_of(x + 1, width, columns) - first_of(x, width, columns));
      // Half of the cell at least: the mean of a few stray matches says nothing of it.
      const bool enough = counts[y][x] > 0 && 2 * counts[y][x] >= pixels;
      const int32_t mean = enough ? (sums[y][x] + 8 * counts[y][x]) / (16 * counts[y][x]) : 0;
      features.row<uint8_t>(y)[x] = static_cast<uint8_t>(std::min(mean, 255));
    }
  }
}

Counts shrink_depths(const Image& depth_map, int disparities) noexcept {
  Counts counts{};
  const int width = depth_map.spec.width, height = std::min<int>(depth_map.spec.height, disparities);
  for (int d = 1; d < height; ++d) {
    const int16_t* row = depth_map.row<int16_t>(d);
    auto& count = counts[rows * d / disparities];
    for (int x = 0; x < columns; ++x)
      for (int u = first_of(x, width, columns), end = first_of(x + 1, width, columns); u < end; ++u) count[x] += row[u];
  }
  return counts;
}

/// `column`: what is in the columns of the picture that make up one of ours, px.
void outline(const Counts& counts, const Image& disparity, Image& features) noexcept {
  const int width = disparity.spec.width, height = disparity.spec.height;
  for (int x = 0; x < columns; ++x) {
    const int column = height * (first_of(x + 1, width, columns) - first_of(x, width, columns));
    int nearest = rows - 1;
    while (nearest > 0 && 16 * counts[nearest][x] < least_sixteenths * column) --nearest;
    features.row<uint8_t>(0)[x] = static_cast<uint8_t>(nearest);
    if (features.spec.height < 2) continue;
    const int level = nearest == 0 ? 0 : height_levels * counts[nearest][x] / column;
    features.row<uint8_t>(1)[x] = static_cast<uint8_t>(std::min(level, height_levels));
  }
}

}  // namespace

ImageSpec feature_spec(Encoding encoding) {
  const bool contours = encoding == Encoding::contour || encoding == Encoding::contour_height;
  const int height = !contours ? rows : encoding == Encoding::contour ? 1 : 2;
  return {Pixel::gray8, 0, columns, static_cast<uint16_t>(height)};
}

size_t active_features(Encoding encoding) {
  return encoding == Encoding::contour || encoding == Encoding::contour_height ? columns : columns * rows;
}

std::string_view name(Encoding encoding) {
  switch (encoding) {
    case Encoding::disparity_map: return "disparity-map";
    case Encoding::depth_map: return "depth-map";
    case Encoding::contour: return "contour";
    case Encoding::contour_height: return "contour-height";
  }
  return "unknown";
}

std::optional<Encoding> encoding_named(std::string_view wanted) {
  for (const Encoding encoding : encodings)
    if (name(encoding) == wanted) return encoding;
  return std::nullopt;
}

void make_features(Encoding encoding, const Image& disparity, const Image& depth_map, int disparities, Image& features) noexcept {
  if (encoding == Encoding::disparity_map) return shrink_disparities(disparity, features);
  const Counts counts = shrink_depths(depth_map, disparities);
  if (encoding != Encoding::depth_map) return outline(counts, disparity, features);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) features.row<uint8_t>(y)[x] = static_cast<uint8_t>(std::min(counts[y][x], 255));
}

void feature_ids(Encoding encoding, std::span<const uint8_t> pixels, std::span<uint32_t> ids) noexcept {
  if (encoding == Encoding::contour || encoding == Encoding::contour_height) {
    const bool high = encoding == Encoding::contour_height;
    for (int x = 0; x < columns; ++x) ids[x] = feature_id(x, pixels[x], high ? pixels[columns + x] : 0);
    return;
  }
  for (int y = 0, i = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x, ++i) ids[i] = feature_id(x, y, pixels[i]);
}

void feature_ids(Encoding encoding, const Image& features, std::span<uint32_t> ids) noexcept {
  std::array<uint8_t, columns * rows> pixels;
  const int height = features.spec.height;
  for (int y = 0; y < height; ++y) std::copy_n(features.row<uint8_t>(y), columns, pixels.data() + y * columns);
  feature_ids(encoding, std::span<const uint8_t>(pixels.data(), static_cast<size_t>(columns * height)), ids);
}

}  // namespace vdisp::snow
