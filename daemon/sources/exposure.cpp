// exposure.cpp: exposure times level is about constant, so one step goes most of the way.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/exposure.h"

#include <algorithm>
#include <cmath>

namespace vdisp {
namespace {

constexpr int apart = 4;  // px: enough to measure by
constexpr double shortest_us = 20;
constexpr double most_at_once = 4;           // times: a level near 0 or 255 does not tell how far away it is
constexpr double over_exposed_share = 0.25;  // of the view: then its mean tells too little

}  // namespace

Brightness brightness_of(const Image& view) noexcept {
  int64_t sum = 0, floor = 0, dark = 0, bright = 0, all = 0;
  for (int v = 0; v < view.spec.height; v += apart) {
    const uint8_t* row = view.row<uint8_t>(v);
    int64_t of_row = 0, count = 0;
    for (int u = 0; u < view.spec.width; u += apart, ++count) {
      of_row += row[u];
      dark += row[u] < 8;
      bright += row[u] > 247;
    }
    all += count;
    if (v < view.spec.height / 2) continue;
    sum += of_row;
    floor += count;
  }
  Brightness found;
  if (floor > 0) found.floor_mean = static_cast<double>(sum) / static_cast<double>(floor);
  if (all > 0)
    found.dark = static_cast<double>(dark) / static_cast<double>(all),
    found.bright = static_cast<double>(bright) / static_cast<double>(all);
  return found;
}

std::optional<ExposureSetting> FloorExposure::see(const Brightness& brightness) noexcept {
  if (wait_ > 0) {
    --wait_;
    return {};
  }
  double factor = wanted_level / std::max(brightness.floor_mean, 1.0);
  if (brightness.bright > over_exposed_share) factor = std::min(factor, 0.5);
  if (std::abs(factor - 1) <= tolerated) return {};
  factor = std::clamp(factor, 1 / most_at_once, most_at_once);
  // Both as one amount of light, given out as exposure as far as that goes.
  const double longest = longest_us_ > 0 ? longest_us_ : setting_.exposure_us;
  const double light = setting_.exposure_us * std::pow(10, setting_.gain_db / 20) * factor;
  const ExposureSetting before = setting_;
  setting_.exposure_us = std::clamp(light, std::min(shortest_us, longest), longest);
  setting_.gain_db = std::clamp(20 * std::log10(light / setting_.exposure_us), 0.0, std::max(highest_gain_db_, 0.0));
  const bool changed = std::abs(setting_.exposure_us / before.exposure_us - 1) > 0.01 || std::abs(setting_.gain_db - before.gain_db) > 0.1;
  if (!changed) return {};
  wait_ = frames_to_show;
  return setting_;
}

}  // namespace vdisp
