// show_obstacle.h: stage `obstacles`: the pixels that lie above the limit (paper 3.10.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/core/processor.h"
#include "daemon/stages/projection.h"

namespace vdisp {

/// True where a pixel of row v with this disparity (1/16 px) is an obstacle: `map` and `obstacles` ask the same question.
inline bool above_limit(const CameraGeometry& g, const int16_t* limit, int v, int disparity) {
  const int column = vdisparity_column(g, disparity);
  return column >= 0 && limit[column] > v;
}

/// disparity16 and line16 to mask8: 255 = obstacle.
class ShowObstacle final : public BinaryOperator {
 public:
  ImageSpec accept(const ImageSpec& disparity, const ImageSpec& limit) override;
  bool combine(const Image& disparity, const Image& limit, Image& out) noexcept override;
};

}  // namespace vdisp
