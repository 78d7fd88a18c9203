// local_floor.h: what a FloorModel says of the floor at one depth: its plane, and the profile on it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "daemon/geometry/floor_plane.h"
#include "ipc/records.h"

namespace vdisp {

/// The floor of a frame that has a calibration.
class LocalFloor {
 public:
  LocalFloor(const FloorModel& model, const StereoView& view) : model_(model), view_(view) {}

  FloorPlane plane() const {
    const double down = 1 / (16 * model_.a);
    return {model_.tilt, down, down * (view_.cy - model_.b)};
  }
  /// Height of the local floor over the plane where the floor is `ahead` m away along the ground.
  double elevation(double ahead) const {
    if (model_.profile_count == 0) return 0;
    const int last = static_cast<int>(std::min(model_.profile_count, FloorModel::profile_capacity)) - 1;
    const double at = std::clamp((ahead - static_cast<double>(model_.profile_start_m)) / static_cast<double>(model_.profile_step_m), 0.0,
                                 static_cast<double>(last));
    const int i = std::min(static_cast<int>(at), std::max(last - 1, 0));
    const double low = static_cast<double>(model_.profile_m[i]), high = static_cast<double>(model_.profile_m[std::min(i + 1, last)]);
    return low + (at - i) * (high - low);
  }
  /// The same at a true disparity of the floor, px, above 0.
  double elevation_of(double true_disparity) const {
    if (model_.profile_count == 0) return 0;
    return elevation(floor_ahead(view_.f * view_.baseline / true_disparity, model_.height_m, model_.pitch_rad));
  }
  /// Row, in the middle column, of what lies `above` m over the local floor at this true disparity.
  double row(double true_disparity, double above = 0) const {
    const double row = 16 * model_.a * true_disparity + model_.b;
    const double raise = above + elevation_of(true_disparity);
    return raise == 0 ? row : row - raise * true_disparity / (view_.baseline * std::cos(model_.pitch_rad));
  }

 private:
  const FloorModel& model_;
  StereoView view_;
};

}  // namespace vdisp
