// smooth.h: contracts: noise is taken off a view before it is matched (`smooth`), whichever matcher does that.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Rows [first, last) of `in`, each pixel made from itself and its eight neighbours; rows and columns beyond the image repeat its border.
/// `out` has the size of `in`, is not `in`, and other rows of it are not touched.
///   mean3x3    the mean, rounded to the nearest: what cv::blur gives, 3x3, BORDER_REPLICATE
///   median3x3  the fifth of the nine in order: what cv::medianBlur gives, 3
using Smooth3x3 = void(View8 in, int first, int last, Plane<uint8_t> out);

namespace plain {
Smooth3x3 mean3x3, median3x3;
}

}  // namespace vdisp::kernels
