// encoding.h: what the classifiers see of a pair: four encodings of disparity map and depth map, and the numbers of their features.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "ipc/image.h"

namespace vdisp::snow {

/// Kueblbeck, Ach, Ernst 2005, 2.3 and figure 7.
enum class Encoding : uint32_t {
  disparity_map = 1,  ///< 80x60 pixels, each the mean of the disparities there in whole px; 0: hardly any
  depth_map,          ///< 80x60: four columns of the 320 summed, row = floor(60 d / disparities), counts clipped at 255
  contour,            ///< 80 columns, each the row of the 80x60 depth map in which the nearest obstacle is; 0: none
  contour_height,     ///< the same, and how high the obstacle is in the picture
};
inline constexpr std::array encodings{Encoding::disparity_map, Encoding::depth_map, Encoding::contour, Encoding::contour_height};

inline constexpr int columns = 80, rows = 60;
inline constexpr uint32_t vector_length = 1u << 21;
/// A row of a column's depth map is something that stands there if it holds so many sixteenths of the column's pixels: the floor gives
/// each row a few, B / H rows of the picture for a px of disparity.
inline constexpr int least_sixteenths = 1;
/// Heights of contour_height go from 0 to this: the whole picture.
inline constexpr int height_levels = 16;

/// Figure 9: 7 bits column, 6 bits row, 8 bits value; (79, 59, 49) is 1309489.
constexpr uint32_t feature_id(int x, int y, int value) { return static_cast<uint32_t>(x << 14 | y << 8 | value); }

/// gray8: 80x60 for both maps; 80x1: row of the nearest obstacle; 80x2: row 0 that, row 1 its height.
ImageSpec feature_spec(Encoding encoding);
/// Features of each example: 4800, 4800, 80, 80. Exactly one for a pixel or column, whatever is seen.
size_t active_features(Encoding encoding);
/// One word, as in [census] and on command lines: disparity-map, depth-map, contour, contour-height.
std::string_view name(Encoding encoding);
std::optional<Encoding> encoding_named(std::string_view name);

/// `disparity`: disparity16 with whole or part px, what is 0 or less or rejected has none. `depth_map`: count16, as wide, row d counts
/// the pixels of each column with d px; row 0 (no disparity) is left out. `disparities`: px, the rows there are. `features` has the spec
/// of the encoding. Width and height of the views are 80x60 or more.
void make_features(Encoding encoding, const Image& disparity, const Image& depth_map, int disparities, Image& features) noexcept;

/// `ids` has active_features(encoding) places; each is below vector_length. Contours: row = that of the obstacle, value = its height or 0.
void feature_ids(Encoding encoding, const Image& features, std::span<uint32_t> ids) noexcept;
/// The same of the image's pixels, row by row without gaps.
void feature_ids(Encoding encoding, std::span<const uint8_t> pixels, std::span<uint32_t> ids) noexcept;

}  // namespace vdisp::snow
