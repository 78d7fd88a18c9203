// disparity.h: stage `disparity`: for each pixel of the left view how far it lies displaced in the right one, or why that is not known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "daemon/core/processor.h"
#include "daemon/stages/block_matcher.h"
#include "daemon/stages/opencv_matcher.h"
#include "daemon/stages/semi_global_matcher.h"
#include "daemon/stages/smoothing.h"

namespace vdisp {

/// Two gray8 of one size, and with three inputs the floor model of the last frame, to disparity16 (1/16 px). Nothing else in the program
/// knows which matcher it stands on.
class Disparity final : public ImageProcessor {
 public:
  Disparity(Machine& machine, const Config& config);
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override { expectation_.forget(); }

 private:
  void match_blocks(const Image& left, const Image& right, const FloorModel* last, Image& out) noexcept;
  void refuse_speckles(Image& out) noexcept;

  Machine& machine_;
  const Config& config_;
  FloorExpectation expectation_;
  ProvisionalFloor provisional_;
  Smoothing smoothing_;
  std::optional<BlockMatcher> block_;  // one of these is set
  std::optional<SemiGlobalMatcher> semi_global_;
  std::optional<OpenCvMatcher> opencv_;
  std::optional<kernels::SpeckleScratch> speckles_;
};

}  // namespace vdisp
