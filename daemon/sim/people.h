// people.h: people who walk to and fro, and stop before a robot in their way.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "daemon/sim/footprint.h"
#include "daemon/sim/scene.h"

namespace vdisp::sim {

/// Somebody who walks along a line to its end and back.
struct Walker {
  std::vector<Spot> way;
  double speed = 1;  ///< m/s
  double start = 0;  ///< m along the way at the beginning
  double brightness = 110;
};

class People {
 public:
  static constexpr size_t parts = 4;      ///< two legs, trunk, head
  static constexpr double respect = 1.1;  ///< m ahead of them, to a robot's middle, in which they stop
  static constexpr double patience = 3;   ///< s; then they walk back

  explicit People(std::vector<Walker> walkers);
  void step(double seconds, const Spot& robot);
  std::span<const Spot> spots() const { return spots_; }
  /// One after the other, `parts` for each.
  void draw(std::span<SceneObject> figures) const;

 private:
  struct State {
    double along = 0, sign = 1, waited = 0, walked = 0, heading = 0;
    std::vector<double> lengths;  ///< to each corner of the way
  };
  void settle(size_t i);

  std::vector<Walker> walkers_;
  std::vector<State> states_;
  std::vector<Spot> spots_;
};

}  // namespace vdisp::sim
