// ditches.cpp: part of `surface`: which of what hides its foot is the far wall of a ditch.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/stages/limits_mm.h"
#include "daemon/stages/upright.h"

namespace vdisp {
namespace {

constexpr float lean = 0.5f;                         // of its height: what leans more is a slope
constexpr float part_of_ditch = 0.45f;               // of max_height: what is seen of the far wall
constexpr float foot_off = 1;                        // px: a foot that is hidden may be matched so far off
constexpr float smooth = 0.03f, dents_of_rough = 5;  // of max_height: how uneven a smooth floor is; of what is more: its dents
constexpr float floor_within = 1.5f;                 // m behind the far side of a ditch
constexpr float rough_slope = 0.15f;                 // of that floor, in the mean
constexpr int least_floor = 3;                       // samples of it

constexpr int sparse = 8;  // samples of the floor, of those that upright things are looked for in

}  // namespace

float Upright::dents(const Marks& marks, int least_disparity) const noexcept {
  // Feet of what stands on the floor, and walls below its edge, are a smaller part than half of what is as high as floor.
  std::array<int, 256> of_height{};  // mm
  int count = 0;
  const int most = LimitsMm(config_).step;
  for (int v = down_ / 2; v < marks.disparity.spec.height; v += sparse * down_) {
    const int16_t *d = marks.disparity.row<int16_t>(v), *height = marks.height.row<int16_t>(v);
    for (int u = across_ / 2; u < marks.disparity.spec.width; u += sparse * across_) {
      if (d[u] < least_disparity || std::abs(height[u]) > most) continue;
      ++of_height[static_cast<size_t>(std::min(std::abs(height[u]), 255))];
      ++count;
    }
  }
  size_t median = 0;
  for (int sum = of_height[0]; 2 * sum < count; sum += of_height[median]) ++median;
  return dents_of_rough * std::max(static_cast<float>(median) / 1000 - smooth * static_cast<float>(config_.limit.max_height), 0.0f);
}

bool Upright::floor_goes_on(std::span<const Sample> samples, size_t end) const noexcept {
  const Sample& top = samples[end - 1];
  const float reach = depth(top, lean);
  int floor = 0;
  for (size_t i = end; i < samples.size() && samples[i].ahead <= top.ahead + floor_within && !gap(samples[i - 1], samples[i]); ++i) {
    const float on = samples[i].ahead - top.ahead;
    if (std::abs(samples[i].up - top.up) > level() + rough_slope * on || samples[i].ahead < samples[i - 1].ahead - reach) return false;
    if (++floor >= least_floor && on > 2 * reach) return true;
  }
  return false;
}

bool Upright::is_ditch(std::span<const Sample> samples, size_t first, size_t end, const Sample& edge, const Rise* same) const noexcept {
  const Sample& top = samples[end - 1];
  const float rises = top.up - samples[first].up, least = part_of_ditch * static_cast<float>(config_.limit.max_height) + scale_.dents;
  if (std::abs(top.up - edge.up) > level() || rises < least) return false;
  // What goes on from the column before is as sure as it was there.
  return ((same && same->ditch) || rises >= least + rise_of(foot_off, samples[first])) && floor_goes_on(samples, end);
}

}  // namespace vdisp
