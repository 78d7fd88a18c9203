// reach.h: where a robot can get to from where it starts, on a grid; and ways from one such place to another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/sim/floor_plan.h"

namespace vdisp::sim {

class Reach {
 public:
  static constexpr double cell = 0.2;  ///< m

  /// Looks at the square about `middle`, `extent` m to each side, for places with `room` m to the next thing.
  Reach(const FloorPlan& plan, const Spot& start, const Spot& middle, double extent, double room);

  /// Places that can be reached, the start's first; empty where the start itself has no room.
  const std::vector<Spot>& places() const { return places_; }
  /// m^2.
  double area() const { return cell * cell * static_cast<double>(places_.size()); }
  /// Whether one of them lies at the border of the square: there is a way out.
  bool open() const { return open_; }
  /// A shortest way over the grid from one of places() to another, both given by their number.
  std::vector<Spot> way(size_t from, size_t to) const;

 private:
  std::vector<int32_t> spread(int32_t from) const;
  Spot spot(int32_t index) const;

  Spot corner_;
  int side_;
  bool open_ = false;
  std::vector<uint8_t> free_;
  std::vector<Spot> places_;
  std::vector<int32_t> cells_;  ///< of places_
};

}  // namespace vdisp::sim
