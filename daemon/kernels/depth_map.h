// depth_map.h: contract: how often each disparity occurs in each column: the bird's-eye view (u-disparity).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// counts.row(d)[x] = how many pixels of column x have a disparity of d whole px (Kueblbeck, Ach, Ernst 2005, 2.3), at most 32767. Row 0
/// is empty: at less than one px, or none, nothing is known to be there, nor what lies beyond the last row. `disparity` is 1/16 px, less
/// than 16 is none; `counts` has the same width. `scratch`: depth_scratch() elements.
using CountDepth = void(Plane<const int16_t> disparity, Plane<int16_t> counts, uint8_t* scratch);

/// A byte a pixel, and room for a vector behind it.
constexpr size_t depth_scratch(int width, int height) { return static_cast<size_t>(width) * static_cast<size_t>(height) + 64; }

namespace plain {
CountDepth count_depth;
}

}  // namespace vdisp::kernels
