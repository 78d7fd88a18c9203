// misalignment.h: what the rows of matches say of how the right camera stands: shift, rotation, size.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/geometry/frames.h"
#include "daemon/tools/calibrate/row_matches.h"

namespace vdisp::calibrate {

/// A right camera turned further by w about x, y, z moves what it sees by f (-wx + wz x + wy x y) rows, and one of another f by f s y.
/// With x, y = (u - cx) / f, (v - cy) / f. What rows cannot tell: a shift is a rotation about x as well.
struct Misalignment {
  double shift_px = 0;               ///< in the middle of the image
  double roll_rad = 0, yaw_rad = 0;  ///< about z, about y
  double scale = 0;                  ///< of the right view, fraction
  double median_px = 0;              ///< of |rows|, before
  double remaining_px = 0;           ///< and after all this is taken out
  size_t matches = 0;
};

/// Least squares with Tukey's weights. At least 20 matches.
Misalignment fit_misalignment(const std::vector<RowMatch>& matches, const StereoView& view);

}  // namespace vdisp::calibrate
