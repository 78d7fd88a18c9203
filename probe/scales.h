// scales.h: the fixed scales of the pictures: a colour means the same in every frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>

#include "ipc/image.h"
#include "probe/paint.h"

namespace vdisp {

/// Disparities from..to (px) share the palette: the matcher's search range.
struct DisparityScale {
  int from, to;
};
inline DisparityScale disparity_scale(const CameraGeometry& camera) {
  const int range = camera.disparities > 0 && camera.disparities <= 4096 ? camera.disparities : 64;
  const int from = std::clamp(camera.min_disparity, -4096, 4096);
  return {from, from + range};
}

inline constexpr int votes_scale = 512;                                 ///< counts of the v-disparity, logarithmic
inline constexpr int height_scale_from = -500, height_scale_to = 1500;  ///< mm over the floor

/// Stages of gray8 whose pixels are codes: CellReason, Surface, and TruthCell.
inline std::string_view last_part(std::string_view topic) { return topic.substr(topic.rfind('/') + 1); }  // npos + 1 is 0
inline bool is_reason(std::string_view topic) { return last_part(topic) == "reason" || last_part(topic) == "fused_reason"; }
inline bool is_surface(std::string_view topic) { return last_part(topic) == "surface"; }
inline bool is_true_cells(std::string_view topic) { return last_part(topic) == "map_cells"; }

/// Of the second detector: counts by column and disparity; what the classifiers see; bits of comparisons.
inline bool is_depth_map(std::string_view topic) { return topic == "depth_map"; }
inline bool is_features(std::string_view topic) { return topic == "features"; }
inline bool is_census(std::string_view topic) { return topic.starts_with("census/"); }
/// One value a column (and its height): drawn as a curve over the rows that a map of the same features has.
inline bool is_contour(std::string_view topic, const Image& image) { return is_features(topic) && image.spec.height <= 2; }
inline constexpr int contour_rows = 60, contour_heights = 16;

/// Rows of the picture that a line16 belongs to.
inline int line_rows(const Image& image, const PaintStyle& style) {
  if (style.picture_rows > 0) return style.picture_rows;
  const float guess = 2 * image.camera.cy;
  return guess >= 40 && guess <= 8192 ? static_cast<int>(std::lround(guess)) : 480;
}

}  // namespace vdisp
