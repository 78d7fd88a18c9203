// vdisparity.h: stage `vdisparity`: for each row of the image, how often each disparity occurs in it (paper 3.7, algorithm 1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/kernels/kernels.h"

namespace vdisp {

/// disparity16 to count16 of the image's height; column = disparity in 1/16 px - 16 * minDisparity, 16 * ndisp columns.
class VDisparity final : public ImageFilter {
 public:
  explicit VDisparity(const Config& config) : config_(config) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  const Config& config_;
  const kernels::Kernels kernels_ = kernels::kernels();
  std::vector<uint16_t> scratch_;
};

}  // namespace vdisp
