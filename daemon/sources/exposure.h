// exposure.h: how bright the floor is, and how long to expose for it, both cameras alike.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "ipc/image.h"

namespace vdisp {

/// Brightness of a view.
struct Brightness {
  double floor_mean = 0;  ///< mean level of the lower half, 0..255
  double dark = 0;        ///< share of pixels below 8
  double bright = 0;      ///< share of pixels above 247
};
/// Of every fourth pixel of every fourth row.
Brightness brightness_of(const Image& view) noexcept;

struct ExposureSetting {
  double exposure_us, gain_db;
};

/// Steers the floor's mean level to the middle: exposure first, gain when exposure ends. It waits for a setting to show before it sets
/// the next one.
class FloorExposure {
 public:
  static constexpr double wanted_level = 110, tolerated = 0.12;
  static constexpr int frames_to_show = 4;

  FloorExposure(ExposureSetting first, double longest_us, double highest_gain_db)
      : setting_(first), longest_us_(longest_us), highest_gain_db_(highest_gain_db) {}
  /// Once a pair, with the mean of both views. A new setting, where one is needed.
  std::optional<ExposureSetting> see(const Brightness& brightness) noexcept;
  const ExposureSetting& setting() const noexcept { return setting_; }

 private:
  ExposureSetting setting_;
  double longest_us_, highest_gain_db_;
  int wait_ = 0;
};

}  // namespace vdisp
