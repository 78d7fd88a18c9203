// underfoot.cpp: height tells a slope ahead from a rover that nods, and the near end tells it from a wrong mounting.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/underfoot.h"

#include <cmath>

namespace vdisp {
namespace {

constexpr double height_noise = 1.0 / 3;  // of heightTolerance: a floor that is seen is measured better
constexpr double meets = 0.03;            // of the disparity: two planes are one ground there

}  // namespace

std::optional<FloorPlane> plane_underfoot(const FloorPlane& seen, double near_row, const FloorPlane* turned, const StereoView& view,
                                          const Config& config) {
  const double height = config.mounting.height, pitch = config.expected_pitch();
  if (!view.calibrated() || !(height > 0)) return std::nullopt;
  const PlanePose pose = pose_of(seen, view);
  if (std::abs(pose.height / height - 1) <= height_noise * config.mounting.heightTolerance) return std::nullopt;
  const double there = seen.down * near_row + seen.middle;
  const auto met = [&](double pitch_then) -> std::optional<FloorPlane> {
    if (std::isnan(pitch_then)) return std::nullopt;
    const FloorPlane plane = plane_of({pitch_then, pose.roll, height}, view);
    if (std::abs(plane.down * near_row + plane.middle - there) > meets * there) return std::nullopt;
    return plane;
  };
  if (turned) {
    if (const auto plane = met(pose_of(*turned, view).pitch)) return plane;
  }
  return met(pitch);
}

}  // namespace vdisp
