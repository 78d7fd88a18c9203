// texture.h: surfaces that repeat without a seam, each at many resolutions, so that near and far are drawn without aliasing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/sim/scene.h"

namespace vdisp::sim {

/// A square of 8-bit texels and its halvings down to one texel. Each word holds a texel and its neighbours to the right, below
/// and below right (lowest byte first), so that one read serves a bilinear sample.
struct Textures {
  static constexpr int log_size = 9, size = 1 << log_size, levels = log_size + 1;
  static constexpr int words = ((1 << (2 * log_size + 2)) - 1) / 3;  ///< of one surface with all its levels
  /// Where a level begins: the sum of the levels before it.
  static constexpr int level_start(int level) { return ((1 << (2 * log_size + 2)) - (1 << (2 * log_size + 2 - 2 * level))) / 3; }
  std::vector<uint32_t> texels;  ///< surface by surface, level by level
};
/// `tiled`: a mosaic that repeats every 32 texels takes the place of gravel, which is the ground's.
Textures make_textures(uint32_t seed, bool tiled = false);

/// Packs rows of 8-bit values as above; the border repeats from the other side, or the last value does.
std::vector<uint32_t> pack(const std::vector<uint8_t>& values, int side, bool repeats);

}  // namespace vdisp::sim
