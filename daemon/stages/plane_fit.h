// plane_fit.h: part of `floor`: a plane of disparities, fitted to the points that lie on it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/geometry/floor_plane.h"
#include "daemon/kernels/kernels.h"

namespace vdisp {

inline constexpr kernels::PlaneReach plane_reach{0.75f, 0.03f};  // px, and of the disparity: rough ground is rough in proportion

/// n points of an image that reaches so far from its middle, px.
struct PlanePoints {
  kernels::DisparityPoints lists;
  size_t n;
  double half_width, half_height;
};

/// The plane that lies best in what is within `wider` times plane_reach of this one: least squares of disparities, px, by Tukey's weight
/// (Beaton and Tukey 1974), on the nearer side within less, as what stands on a floor is nearer. The same plane where too little is.
FloorPlane fitted(const FloorPlane& plane, const PlanePoints& points, double wider, const kernels::Kernels& kernels);

/// Fitted again and again, up to `most` times, until it moves by less than 1/100 px anywhere in the image: the plane that is found does
/// not depend on the guess then.
FloorPlane settled(FloorPlane plane, const PlanePoints& points, int most, const kernels::Kernels& kernels);

}  // namespace vdisp
