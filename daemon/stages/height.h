// height.h: stage `height`: how high above the floor each pixel lies.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"

namespace vdisp {

/// disparity16 and FloorModel to height16: mm above the floor of the same disparity, as `limit` reckons; negative below it.
class Height final : public BinaryOperator {
 public:
  explicit Height(const Config& config) : config_(config) {}
  ImageSpec accept(const ImageSpec& disparity, const ImageSpec& model) override;
  bool combine(const Image& disparity, const Image& model, Image& out) noexcept override;

 private:
  const Config& config_;
};

}  // namespace vdisp
