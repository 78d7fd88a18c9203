// prefilter.h: contracts: what makes two views comparable that differ in brightness: their gradient, or how it changes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Rows [first, last) of the x-Sobel of `in`, limited to -cap .. cap, plus cap: out holds 0 .. 2 cap, and cap means no gradient. Rows
/// beyond the image are mirrored at the border row (1 stands for -1); the first and the last column are cap. cap <= 127. `out` has the
/// size of `in`; other rows are not touched. The pre-filter of OpenCV's StereoBM (PREFILTER_XSOBEL).
using XSobel = void(View8 in, int cap, int first, int last, Plane<uint8_t> out);

/// Rows [first, last) of the Laplacian of a Gaussian of `in`, limited to -cap .. cap, plus cap: 0 .. 2 cap, and cap means even brightness,
/// be it flat or a ramp; a bright spot gives less than cap. `window` is 9 or 11 pixels, as SVS has them (convx, convy). Rows and columns
/// beyond the image are mirrored at the border ones (1 stands for -1). cap <= 127. `out` has the size of `in`, is not `in`; other rows are
/// not touched.
///   Gaussian   g: box filters of 3, 3 and window - 6 pixels in each direction; 1 3 6 7 6 3 1, sigma 1.41, or 1 3 6 8 9 8 6 3 1, sigma 1.83
///   Laplacian  h: g with the second difference 1 -2 1; the response is h across of g down, plus g across of h down
///   scale      1/64 or 1/128, rounded twice, half up: to quarters before the last box across, within 16 bits, then to 1/16 or 1/32. A step
///              of n levels gives 1.3 n or 1.1 n where x_sobel gives 4 n, yet the mean contrast |out - cap| of real images is like
///              x_sobel's: with cap 31, over seven of streets, rooms, rocks and cloth, 17.4 or 16.7 where x_sobel has 17.6.
using LogFilter = void(View8 in, int window, int cap, int first, int last, Plane<uint8_t> out);

/// Index of the row or column that stands for x in an image of so many: mirrored at the border ones.
constexpr int mirrored_at_border(int x, int count) {
  if (count == 1) return 0;
  while (x < 0 || x >= count) x = x < 0 ? -x : 2 * (count - 1) - x;
  return x;
}

namespace plain {
XSobel x_sobel;
LogFilter log_filter;
}  // namespace plain

}  // namespace vdisp::kernels
