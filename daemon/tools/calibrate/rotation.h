// rotation.h: a rotation matrix as axis times angle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace vdisp::calibrate {

/// rad about x, y, z; of a rotation by less than half a turn, row-major.
inline std::array<double, 3> rotation_vector(const std::array<double, 9>& r) {
  const std::array<double, 3> axis{r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  const double angle = std::acos(std::clamp((r[0] + r[4] + r[8] - 1) / 2, -1.0, 1.0)), sine = std::sin(angle);
  const double scale = sine > 1e-9 ? angle / (2 * sine) : 0.5;
  return {axis[0] * scale, axis[1] * scale, axis[2] * scale};
}

}  // namespace vdisp::calibrate
