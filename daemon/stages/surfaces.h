// surfaces.h: stages `height`, `surface` and what stands over the local floor, for [Floor] model = plane | profile.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/kernels/aligned.h"
#include "daemon/stages/filling.h"
#include "daemon/stages/machine.h"
#include "daemon/stages/rising_ground.h"
#include "daemon/stages/upright.h"

namespace vdisp {

/// disparity16, FloorModel and the left view to
///   height16     mm over the local floor
///   gray8        what each pixel is (Surface)
///   disparity16  the disparities of obstacles alone, all others refused
///   disparity16  those of overhangs
///
/// A pixel with the true disparity d' lies H (1 - d_floor / d') over the plane of a camera H high, with d_floor what the plane has there:
/// for both points of a ray, distances over the plane and depths are in proportion. What stands upright is looked for besides (Upright): no
/// part of it is floor. Ground that rises beside the way is floor (RisingGround). What is even between the edges of obstacles becomes
/// obstacle (Filling).
class Surfaces final : public ImageProcessor {
 public:
  Surfaces(Machine& machine, const Config& config)
      : machine_(machine), config_(config), upright_(config), rising_(config), filling_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  Machine& machine_;
  const Config& config_;
  Upright upright_;
  RisingGround rising_;
  Filling filling_;
  kernels::Aligned<kernels::HeightOf> heights_;  // kernels::HeightTable
};

}  // namespace vdisp
