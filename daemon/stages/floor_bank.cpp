// floor_bank.cpp: part of `floor`: how the ground lies across the way, as a whole.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/stages/floor_profile.h"

namespace vdisp {
namespace {

constexpr float limits[] = {1.0f, 0.75f, 0.5f};  // of max_height, round by round: so far off its distance's ground a point is none of it
constexpr float most_counted = 15;               // points of a distance
constexpr float no_bank = 10;                    // points, 1 m aside, that say so
constexpr double most = 0.1;                     // m per m: what is more is no error of a plane

}  // namespace

/// The plane is fitted to disparities, where the ground at the rover's feet fills most of the picture. On rough ground that is a bump or
/// two, and 2 m aside a plane that leans with them is a step off. In metres, distance by distance, all ground that is seen counts alike.
double FloorProfile::bank(const FloorModel& model) const noexcept {
  struct Sums {
    float n, x, y, xx, xy;
  };
  std::array<float, bins> level{};  // of the ground in the middle, m over the plane
  std::copy(std::begin(model.profile_m), std::end(model.profile_m), level.begin());
  const float max_height = static_cast<float>(config_.limit.max_height), side = static_cast<float>(config_.map.width / 2);
  float bank = 0;
  for (const float limit : limits) {
    std::array<Sums, bins> sums{};
    const float per_reach = 1 / (limit * max_height);
    for (const GroundPoint& p : ground_) {
      const float off = (p.height - level[static_cast<size_t>(p.bin)] - bank * p.right) * per_reach, near = 1 - off * off;
      if (near <= 0 || std::abs(p.right) > side) continue;
      const float weight = near * near, x = weight * p.right;
      Sums& s = sums[static_cast<size_t>(p.bin)];
      s.n += weight;
      s.x += x;
      s.y += weight * p.height;
      s.xx += x * p.right;
      s.xy += x * p.height;
    }
    float xx = no_bank, xy = 0;
    for (const Sums& s : sums) {
      if (s.n < 1) continue;
      const float part = std::min(most_counted / s.n, 1.0f);
      xx += part * (s.xx - s.x * s.x / s.n);
      xy += part * (s.xy - s.x * s.y / s.n);
    }
    bank = xy / xx;
    for (size_t bin = 0; bin < bins; ++bin) {
      if (sums[bin].n >= 1) level[bin] = (sums[bin].y - bank * sums[bin].x) / sums[bin].n;
    }
  }
  return std::clamp(static_cast<double>(bank), -most, most);
}

}  // namespace vdisp
