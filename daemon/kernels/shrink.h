// shrink.h: contract: a view made smaller by averaging areas.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Rows [first, last) of `out`, each pixel the mean of factor x factor pixels of `in`, rounded to the nearest, half up. `out` is floor(in /
/// factor) wide and high; what is left over at the right and below is not looked at. Other rows are not touched. factor 1 .. 16.
using Shrink = void(View8 in, int factor, int first, int last, Plane<uint8_t> out);

namespace plain {
Shrink shrink;
}

}  // namespace vdisp::kernels
