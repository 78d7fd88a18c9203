// smooth_sizes.h: image sizes that hurt the smoothing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "tests/kernels/check.h"

namespace vdisp::kernels {

/// Widths around the strips the fast forms work in, and those of check.h.
inline std::vector<std::pair<int, int>> smooth_sizes() {
  std::vector<std::pair<int, int>> all = awkward_sizes;
  for (int width : {320, 639, 640, 641, 642, 703, 705, 1279, 1281, 1400}) all.emplace_back(width, 5);
  return all;
}

}  // namespace vdisp::kernels
