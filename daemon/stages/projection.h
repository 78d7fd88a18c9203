// projection.h: what the stages behind the disparity take from an image's header and the configuration to get metres.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/geometry/frames.h"
#include "ipc/records.h"

namespace vdisp {

inline StereoView stereo_view(const Image& image) {
  const CameraGeometry& g = image.camera;
  return {g.f, g.cx, g.cy, g.baseline, g.cx_offset};
}

/// Pitch for metres: the number in angRot, or with angRot = auto the one measured from the floor. NaN: not known.
inline double pitch_in_use(const Config& config, const FloorModel& floor) {
  return config.automatic_pitch() ? floor.pitch_rad : config.limit.angRot;
}

/// Why nothing behind the floor can be said in metres; none if it can.
inline Reason no_metres(const Image& image, double pitch) {
  if (!stereo_view(image).calibrated()) return Reason::no_calibration;
  return std::isnan(pitch) ? Reason::no_pitch : Reason::none;
}

/// Column of the v-disparity for a disparity in 1/16 px; -1 outside the search range or not nearer than infinity.
inline int vdisparity_column(const CameraGeometry& g, int disparity) {
  const int column = disparity - 16 * g.min_disparity;
  const bool inside = column >= 0 && column<16 * g.disparities&& static_cast<float>(disparity)> 16 * g.cx_offset;
  return inside ? column : -1;
}

/// True disparity d' in px of a column of the v-disparity.
inline double true_disparity(const CameraGeometry& g, int column) {
  return column / 16.0 + g.min_disparity - static_cast<double>(g.cx_offset);
}

}  // namespace vdisp
