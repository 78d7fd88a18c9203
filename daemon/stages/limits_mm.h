// limits_mm.h: the limits of height as the height image has them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "config/config.h"
#include "ipc/image.h"

namespace vdisp {

/// mm over the local floor, to the nearest. From `step` on: obstacle; from `clearance` on: overhang; from minus `hole` on downwards: below
/// the floor. A clearance is at most 32 m, which height16 can tell.
struct LimitsMm {
  int step, clearance, hole;

  explicit LimitsMm(const Config& config)
      : step(rounded(config.limit.max_height)),
        clearance(rounded(config.limit.clearance)),
        hole(rounded(hole_of_step * config.limit.max_height)) {}

 private:
  static int rounded(double metres) { return static_cast<int>(std::lround(1000 * metres)); }
};

}  // namespace vdisp
