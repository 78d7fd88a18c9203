// robot.h: the platform of the census + SNoW paper (1.1): 40 x 40 x 80 cm, two driven wheels, the camera over the middle of their axle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/sim/footprint.h"
#include "daemon/sim/simulator.h"

namespace vdisp::sim {

class Robot {
 public:
  static constexpr double side = 0.4, height = 0.8;     ///< m
  static constexpr double climbs = 0.05;                ///< m: wheels roll over what is no higher
  static constexpr double wheel_base = 0.36;            ///< m
  static constexpr double most_wheel_speed = 1;         ///< m/s
  static constexpr double speeding = 1, braking = 1.5;  ///< m/s^2 of a wheel: away from standing, towards it
  static constexpr double most_back = 0.3;              ///< m/s
  static constexpr double most_turn = 1.5;              ///< rad/s

  Spot spot;           ///< the middle, which it turns about
  double heading = 0;  ///< rad, positive to the left

  double speed() const { return (left_ + right_) / 2; }
  double turn_rate() const { return (right_ - left_) / wheel_base; }
  bool stands() const { return left_ == 0 && right_ == 0; }
  void stop() { left_ = right_ = 0; }
  /// Goes on for so long; the wheels' speeds follow the order as fast as they can.
  void move(const Order& order, double seconds);
  Footprint outline() const { return {spot, side, side, heading}; }

 private:
  double left_ = 0, right_ = 0;  ///< m/s of the wheels
};

}  // namespace vdisp::sim
