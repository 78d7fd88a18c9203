// expert.h: a driver that knows the world: what it would do at each place, and how it drives where it is let.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/sim/chance.h"
#include "daemon/sim/floor_plan.h"
#include "daemon/sim/robot.h"

namespace vdisp::sim {

class Expert {
 public:
  static constexpr double half_strip = 0.32;        ///< m to each side of the robot's middle that must be free
  static constexpr double near = 1.0, clear = 1.2;  ///< m from its middle: nearer is an obstacle; free again
  static constexpr double open = 1.4;               ///< m: a direction that is worth turning to
  static constexpr double far = 4;                  ///< m it looks
  static constexpr double speed = 0.5, turn = 0.8;  ///< m/s, rad/s
  static constexpr double room = 0.3;               ///< m from its middle to the next thing: enough to turn on the spot

  static constexpr double label_near = 1.5;  ///< m from its middle: what is nearer is labelled

  struct Judgement {
    Steering steering = Steering::forward;  ///< what it does
    Steering label = Steering::forward;     ///< what it says of this view alone
    double clearness = 1;                   ///< as in Decision
    double way = far;                       ///< m straight ahead
    double since = 0;                       ///< s, that the label is the same
    uint64_t changes = 0;                   ///< of the label
  };

  /// `exploration`: share of its drive in which it follows chance.
  Expert(uint64_t seed, double exploration) : chance_(seed + 0xe4b1), exploration_(exploration) {}

  /// What it does has the paper's three states (figure 10): a direction is kept until the way is free, unless the other has become much
  /// shorter. The label is for classifiers that remember nothing and see to 30 degrees on each side: an obstacle is what is nearer than
  /// label_near, which leaves half a metre beyond the blind zone of a usual camera, whatever went before; its side is that of the first
  /// open direction in view, else of more room.
  const Judgement& judge(const FloorPlan& plan, const Robot& robot, double seconds);
  const Judgement& judgement() const { return judgement_; }
  /// What it does about it for the next frame's time. Never into anything that stands still.
  Order drive(const FloorPlan& plan, const Robot& robot, double seconds);

 private:
  enum class Mood { sober, swing, push, spin };
  struct Turns {
    double left, right;  ///< rad to the first open direction
    double lean;         ///< m: more room on the left
  };
  static Steering side_in_view(const Turns& turns);
  Turns look_round(const FloorPlan& plan, const Robot& robot) const;
  void choose_mood();

  Chance chance_;
  double exploration_;
  Judgement judgement_;
  Mood mood_ = Mood::sober;
  double mood_left_ = 2, mood_speed_ = 0, mood_turn_ = 0;
};

}  // namespace vdisp::sim
