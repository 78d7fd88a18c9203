// decide.h: stage `decision`: forward, left or right, by one detector or both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "daemon/core/processor.h"
#include "daemon/stages/map_driver.h"

namespace vdisp {

/// A grid to a Decision: int8 with its reasons (gray8), or count16. Blind where an input is: nobody knows the way then, and the state stays
/// what it was.
class Decide final : public ImageProcessor {
 public:
  explicit Decide(const Config& config) : config_(config), map_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  const Config& config_;
  MapDriver map_;
  SteeringMachine machine_;
};

}  // namespace vdisp
