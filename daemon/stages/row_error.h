// row_error.h: part of `row_error`: how many rows apart a point of the left view is in the right one, to a fraction of a pixel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ipc/image.h"

namespace vdisp {

inline constexpr int row_error_border = 11;  ///< px that a point keeps from the edges of the image, besides its disparity

/// Texture around (u, v) in all directions: the smaller eigenvalue of the gradients' structure tensor, mean of a window, (grey levels/px)².
/// An edge has none: along it rows cannot be told from columns. (u, v) is at least row_error_border from every edge.
float corner_strength(const Image& view, int u, int v) noexcept;

/// Rows by which what is at (u, v) of the left view lies lower in the right one, px: searched up to 3 rows up and down around the
/// disparity (px), then refined in both directions, as a wrong row pulls the disparity of slanted edges along. Empty where it is not the
/// same thing, lies at the end of the search or leaves the image.
std::optional<float> row_error(const Image& left, const Image& right, int u, int v, float disparity) noexcept;

}  // namespace vdisp
