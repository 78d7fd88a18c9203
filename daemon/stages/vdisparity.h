// vdisparity.h: stage `vdisparity`: for each row of the image, how often each disparity occurs in it (paper 3.7, algorithm 1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// disparity16 to count16 of the image's height; column = disparity in 1/16 px - 16 * minDisparity, 16 * ndisp columns.
class VDisparity final : public ImageFilter {
 public:
  VDisparity(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Machine& machine_;
  const Config& config_;
  std::vector<uint16_t> scratch_;
};

}  // namespace vdisp
