// depth_map.h: stage `depth_map`: how often each disparity occurs in each column: the scene from above.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// disparity16 to count16, as wide, row d counting the pixels of each column whose disparity is d whole px; row 0 is empty. How high what
/// stands there is in the picture (census + SNoW, 2.3 and figure 6).
class DepthMap final : public ImageFilter {
 public:
  DepthMap(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Machine& machine_;
  const Config& config_;
  std::vector<uint8_t> scratch_;
};

}  // namespace vdisp
