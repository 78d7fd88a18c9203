// decide.h: stage `decision`: forward, left or right, by one detector or both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/core/processor.h"
#include "daemon/stages/ways.h"

namespace vdisp {

/// What Ways takes to a Decision. With both detectors the way is free where both say so: an obstacle that one of them sees is one, and that
/// one tells where to evade; where both see one, the map, which measures.
///
/// Blind where an input is: nobody knows the way then, and the state stays what it was. But where the map alone is blind (given
/// even_blind) and the classifiers see an obstacle, it is turned from as they say: a wall that fills the view hides the floor, and blind
/// before it the rover would stand for good. Turning shows the map another view; ahead it goes only where both see the way free.
class Decide final : public ImageProcessor {
 public:
  explicit Decide(const Config& config) : config_(config), ways_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;
  void begin_anew() noexcept override { machine_ = {}; }

 private:
  const Config& config_;
  Ways ways_;
  SteeringMachine machine_;
};

}  // namespace vdisp
