// census_disparity.h: stage `census_disparity`: block matching of the census images by the bits that differ.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Both census images and the left smoothed view to disparity16, whole px (census + SNoW, 2.2 and 2.3): the shift at which the Hamming
/// distance, summed over the block, is least. The confidence test: on average over the shifts the distance must be greater than that by
/// [census] confidence bits a pixel, or there is too little texture (low_texture).
///
/// Blind where the left view is dark or over-exposed, and where hardly a pixel has a disparity: what a classifier says of nothing is
/// nothing to drive by.
class CensusDisparity final : public ImageProcessor {
 public:
  CensusDisparity(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  Reason blindness(const Image& view, const Image& disparity) const noexcept;

  Machine& machine_;
  const Config& config_;
  std::vector<kernels::HammingScratch> bands_;
};

}  // namespace vdisp
