// prefilter.h: contracts: what makes two views comparable that differ in brightness: their horizontal gradient.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Rows [first, last) of the x-Sobel of `in`, limited to -cap .. cap, plus cap: out holds 0 .. 2 cap, and cap means no gradient. Rows
/// beyond the image are mirrored at the border row (1 stands for -1); the first and the last column are cap. cap <= 127. `out` has the
/// size of `in`; other rows are not touched. The pre-filter of OpenCV's StereoBM (PREFILTER_XSOBEL).
using XSobel = void(View8 in, int cap, int first, int last, Plane<uint8_t> out);

namespace plain {
XSobel x_sobel;
}

}  // namespace vdisp::kernels
