// height_limits.cpp: the limits of [Limit obstacle], and what else than height tells a surface.
// SPDX-License-Identifier: Apache-2.0
#include "probe/height_limits.h"

#include <charconv>

#include "ipc/include/vdisp/control.h"

namespace vdisp {
HeightLimits limits_of(const std::string& path) {
  Control control(path);
  const auto get = [&](const char* key) {
    ParameterInfo info;
    double value = NAN;
    if (control.get(key, info) == Control::Result::done) std::from_chars(info.value.data(), info.value.data() + info.value.size(), value);
    return value;
  };
  const double max_height = get("Limit obstacle.max_height");
  if (std::isnan(max_height)) return {};
  return {max_height, get("Limit obstacle.clearance")};
}

std::string beyond_height(double height, Surface surface, const HeightLimits& limits) {
  if (!limits.known() || !std::isfinite(height)) return "";
  switch (surface) {
    case Surface::floor: return height >= limits.max_height ? "ground: floor leads up to it, no steeper than [Floor] maxSlope" : "";
    case Surface::obstacle: return height < limits.max_height ? "of something upright that rises by max_height at one distance" : "";
    case Surface::below:
      return height > -hole_of_step * limits.max_height ? "the far side of a ditch, which ends level with the floor" : "";
    case Surface::none: return "the low part of what stands upright: no floor, and not known to be high enough";
    case Surface::overhang:
    case Surface::filled: break;
  }
  return "";
}

}  // namespace vdisp
