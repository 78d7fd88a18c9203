// show_obstacle.h: stage `obstacles`: the pixels that lie above the limit (paper 3.10.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// disparity16 and line16 to mask8: 255 = obstacle, as `map` counts it.
class ShowObstacle final : public BinaryOperator {
 public:
  explicit ShowObstacle(Machine& machine) : machine_(machine) {}
  ImageSpec accept(const ImageSpec& disparity, const ImageSpec& limit) override;
  bool combine(const Image& disparity, const Image& limit, Image& out) noexcept override;

 private:
  Machine& machine_;
};

/// gray8 of stage `surface` to mask8: 255 = obstacle.
class ShowSurface final : public ImageFilter {
 public:
  ImageSpec accept(const ImageSpec& surface) override;
  bool filter(const Image& surface, Image& out) noexcept override;
};

}  // namespace vdisp
