// cross_check.h: stage `cross_check`: whether the map and the classifiers say the same of the way ahead.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/core/processor.h"
#include "daemon/stages/ways.h"

namespace vdisp {

/// The images of both detectors, as Ways takes them, to a CrossCheck. It runs where both can see, and counts those frames alone.
class CompareWays final : public ImageProcessor {
 public:
  explicit CompareWays(const Config& config) : ways_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;
  void begin_anew() noexcept override {
    agreed_ = only_map_free_ = only_snow_free_ = 0;
    disagrees_ = false;
  }

 private:
  Ways ways_;
  uint64_t agreed_ = 0, only_map_free_ = 0, only_snow_free_ = 0;
  bool disagrees_ = false;
  int64_t since_ns_ = 0;
};

}  // namespace vdisp
