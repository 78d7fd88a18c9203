// height_limits.h: from which heights on a pixel is an obstacle, or passed below, as the daemon is set now.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include "ipc/image.h"

namespace vdisp {

/// m over the local floor, [Limit obstacle]; NaN: not known.
struct HeightLimits {
  double max_height = NAN, clearance = NAN;
  bool known() const { return max_height > 0 && clearance > 0; }
};

/// Asked through the control socket at this path (empty: the usual places); not known where no daemon of this name answers there.
HeightLimits limits_of(const std::string& control);

/// Why a pixel this high (m) is told to be such a surface, where its height alone does not say: ground that rises, the foot of what stands
/// upright, the far side of a ditch. Empty where it does, or the limits are not known.
std::string beyond_height(double height, Surface surface, const HeightLimits& limits);

}  // namespace vdisp
