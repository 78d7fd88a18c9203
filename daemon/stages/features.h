// features.h: stage `features`: what the classifiers see of a pair, as an image of 80 columns.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/snow/model.h"

namespace vdisp {

/// The front end that the configuration describes, for views of this size: what a model has to be trained with.
snow::Settings front_end(const Config& config, const ImageSpec& view);

/// census_disparity and depth_map to gray8 in one of four encodings (census + SNoW, 2.3 and figure 7).
class Features final : public BinaryOperator {
 public:
  explicit Features(const Config& config) : config_(config), encoding_(front_end(config, {}).encoding) {}
  ImageSpec accept(const ImageSpec& disparity, const ImageSpec& depth_map) override;
  bool combine(const Image& disparity, const Image& depth_map, Image& out) noexcept override;

 private:
  const Config& config_;
  const snow::Encoding encoding_;
};

}  // namespace vdisp
