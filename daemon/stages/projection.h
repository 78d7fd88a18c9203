// projection.h: what the stages behind the disparity take from an image's header and the configuration to get metres.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "config/config.h"
#include "daemon/geometry/frames.h"
#include "daemon/kernels/plane.h"
#include "daemon/kernels/search.h"
#include "ipc/records.h"

namespace vdisp {

inline StereoView stereo_view(const Image& image) {
  const CameraGeometry& g = image.camera;
  return {g.f, g.cx, g.cy, g.baseline, g.cx_offset};
}

/// The line's pitch is told by the operator or the line; planes have measured theirs, and their roll.
inline bool measures_roll(const FloorModel& floor) { return floor.model != FloorKind::line; }

/// Pitch for metres: with a plane or profile the measured one, else the number in angRot, or with angRot = auto the one measured from the
/// floor. NaN: not known.
inline double pitch_in_use(const Config& config, const FloorModel& floor) {
  return config.automatic_pitch() || measures_roll(floor) ? floor.pitch_rad : config.limit.angRot;
}

/// Why nothing behind the floor can be said in metres; none if it can.
inline Reason no_metres(const Image& image, double pitch) {
  if (!stereo_view(image).calibrated()) return Reason::no_calibration;
  return std::isnan(pitch) ? Reason::no_pitch : Reason::none;
}

/// The rows of an image for the kernels.
template <class T>
kernels::Plane<T> plane(Image& image) {
  return {image.row<T>(0), image.spec.width, image.spec.height, static_cast<ptrdiff_t>(image.spec.stride() / sizeof(T))};
}
template <class T>
kernels::Plane<const T> plane(const Image& image) {
  return {image.row<T>(0), image.spec.width, image.spec.height, static_cast<ptrdiff_t>(image.spec.stride() / sizeof(T))};
}

/// The disparities inside the search range and nearer than infinity, and their columns in a v-disparity of this width.
inline kernels::Search search_of(const CameraGeometry& g, int width) {
  const int first = 16 * g.min_disparity, columns = std::min(16 * g.disparities, width);
  const float beyond = std::clamp(std::floor(16 * g.cx_offset) + 1, static_cast<float>(first), static_cast<float>(first + columns));
  return {first, static_cast<int>(beyond), columns};
}

/// True disparity d' in px of a column of the v-disparity.
inline double true_disparity(const CameraGeometry& g, int column) {
  return column / 16.0 + g.min_disparity - static_cast<double>(g.cx_offset);
}

}  // namespace vdisp
