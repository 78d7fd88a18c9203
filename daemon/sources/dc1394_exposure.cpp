// dc1394_exposure.cpp: shutter and gain of a FireWire camera.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/sources/dc1394_camera.h"

namespace vdisp {
namespace {
constexpr double default_period_s = 1.0 / 30;  // where the camera does not tell its rate
}

void Dc1394Camera::prepare_exposure() {
  longest_exposure_us_ = period_s_ * 1e6;
  highest_gain_db_ = 24;
  if (config_.camera.exposeBy == "camera") {
    for (const dc1394feature_t feature : {DC1394_FEATURE_SHUTTER, DC1394_FEATURE_GAIN})
      dc1394_feature_set_mode(camera_, feature, DC1394_FEATURE_MODE_AUTO);
  } else if (!expose(config_.camera.exposure, config_.camera.gain)) {
    refuse(CameraFault::unsupported, "it lets nobody set its shutter; [camera] exposeBy must be camera");
  }
}

/// In units where the camera knows them; else its range is taken for 0 to `period_value`.
bool Dc1394Camera::set_feature(dc1394feature_t feature, double value, double period_value) noexcept {
  dc1394bool_t present = DC1394_FALSE, absolute = DC1394_FALSE;
  if (dc1394_feature_is_present(camera_, feature, &present) != DC1394_SUCCESS || !present) return false;
  dc1394_feature_set_mode(camera_, feature, DC1394_FEATURE_MODE_MANUAL);
  if (dc1394_feature_has_absolute_control(camera_, feature, &absolute) == DC1394_SUCCESS && absolute &&
      dc1394_feature_set_absolute_control(camera_, feature, DC1394_ON) == DC1394_SUCCESS)
    return dc1394_feature_set_absolute_value(camera_, feature, static_cast<float>(value)) == DC1394_SUCCESS;
  uint32_t least = 0, most = 0;
  if (dc1394_feature_get_boundaries(camera_, feature, &least, &most) != DC1394_SUCCESS || most <= least) return false;
  const double share = std::clamp(value / period_value, 0.0, 1.0);
  return dc1394_feature_set_value(camera_, feature, least + static_cast<uint32_t>(std::lround((most - least) * share))) == DC1394_SUCCESS;
}

bool Dc1394Camera::expose(double exposure_us, double gain_db) noexcept {
  const std::lock_guard lock(features_);
  if (!camera_ || !set_feature(DC1394_FEATURE_SHUTTER, exposure_us * 1e-6, period_s_ > 0 ? period_s_ : default_period_s)) return false;
  exposure_us_ = exposure_us;
  set_feature(DC1394_FEATURE_GAIN, gain_db, highest_gain_db_);
  return true;
}

}  // namespace vdisp
