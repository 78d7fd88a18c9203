// map.h: stage `map`: the obstacle pixels counted in a grid on the ground (paper 3.11, algorithm 4).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// disparity16, limit and FloorModel, or the disparities of obstacles alone and FloorModel, to count16, row 0 farthest, the camera below
/// the last row in the middle.
///
/// Where it departs from algorithm 4: axes as in geometry/frames.h (the paper changes them between 2.2 and 3.11); cells are
/// half-open and what lies outside is ignored (at 5 m the paper's column leaves the map, at 0 m its row does); counts saturate.
class Map final : public ImageProcessor {
 public:
  Map(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  Machine& machine_;
  const Config& config_;
  std::vector<int16_t> everything_;  // a limit that everything is above
  kernels::GroundScratch scratch_;
};

}  // namespace vdisp
