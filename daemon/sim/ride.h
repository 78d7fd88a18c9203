// ride.h: a robot's ride through a world: its motion as it is told, what it runs into, and the people around it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/sim/expert.h"
#include "daemon/sim/floor_plan.h"
#include "daemon/sim/people.h"
#include "daemon/sim/reach.h"
#include "daemon/sim/robot.h"
#include "daemon/sim/world.h"

namespace vdisp::sim {

/// Depends on parameters and orders only: the same orders make the same ride.
class Ride {
 public:
  static constexpr double stuck_after = 30, stuck_within = 0.5;  ///< s in which it comes no farther than so many m: it is stuck
  static constexpr double refuge_room = 0.5;                     ///< m to the next thing, where it is put back to

  Ride(const sim_section& parameters, const World& world);

  /// To the next frame. `drive` of the parameters says whose order counts: this one, the expert's, or nobody's.
  void step(const Order& order);
  const RobotReport& report() const { return report_; }
  const Robot& robot() const { return robot_; }
  const People& people() const { return people_; }
  const FloorPlan& plan() const { return plan_; }
  const Reach& reach() const { return reach_; }

 private:
  void move(const Order& order);
  bool has_room(const Spot& spot) const;
  void put();
  void put(const Spot& spot);
  void watch_progress();
  void tell();

  enum class Who { nobody, expert, command } who_;
  double seconds_;  ///< from frame to frame
  FloorPlan plan_;
  Reach reach_;
  People people_;
  Robot robot_;
  Expert expert_;
  Chance chance_;
  RobotReport report_{};
  Spot refuge_, anchor_;                                             ///< the last place with room; where it was when it last made progress
  double unmoved_ = 0;                                               ///< s since then
  enum class Due { nothing, refuge, anywhere } due_ = Due::nothing;  ///< where it is put as soon as there is room
};

}  // namespace vdisp::sim
