// limit.h: stage `limit`: the row, for each disparity, above which something is an obstacle (paper 3.9, algorithm 3).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"

namespace vdisp {

/// line16 and FloorModel to line16: the first row above the floor that is more than max_height higher, not clipped to the image.
/// Closed form of algorithm 3: row = floor row - max_height d' / (B cos t); a test holds the two together.
class Limit final : public BinaryOperator {
 public:
  explicit Limit(const Config& config) : config_(config) {}
  ImageSpec accept(const ImageSpec& floor, const ImageSpec& model) override;
  bool combine(const Image& floor, const Image& model, Image& out) noexcept override;

 private:
  const Config& config_;
};

}  // namespace vdisp
