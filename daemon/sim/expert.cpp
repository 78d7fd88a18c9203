// expert.cpp: looks along strips of the true floor plan.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/expert.h"

#include <algorithm>

namespace vdisp::sim {
namespace {

constexpr double step = 0.0873;  // rad: 5 deg
constexpr int seen = 6;          // steps: the camera sees 30 deg to each side, nearly

}  // namespace

Expert::Turns Expert::look_round(const FloorPlan& plan, const Robot& robot) const {
  constexpr int steps = 36;
  Turns turns{M_PI, M_PI, 0};
  for (int i = 1; i <= steps && (i <= seen || turns.left == M_PI || turns.right == M_PI); ++i) {
    const double left = plan.way(robot.spot, robot.heading + i * step, half_strip, open),
                 right = plan.way(robot.spot, robot.heading - i * step, half_strip, open);
    if (turns.left == M_PI && left >= open) turns.left = i * step;
    if (turns.right == M_PI && right >= open) turns.right = i * step;
    if (i > seen) continue;
    constexpr double ray = 0.05;
    turns.lean += plan.way(robot.spot, robot.heading + i * step, ray, far) - plan.way(robot.spot, robot.heading - i * step, ray, far);
  }
  return turns;
}

Steering Expert::side_in_view(const Turns& turns) {
  const double shorter = turns.right - turns.left;
  const bool opens = std::min(turns.left, turns.right) < (seen + 0.5) * step;
  const bool left = opens && std::abs(shorter) > 0.5 * step ? shorter > 0 : turns.lean > 0;
  return left ? Steering::turn_left : Steering::turn_right;
}

const Expert::Judgement& Expert::judge(const FloorPlan& plan, const Robot& robot, double seconds) {
  constexpr double alike = 0.2, much = 0.5;  // rad
  Judgement& now = judgement_;
  now.way = plan.way(robot.spot, robot.heading, half_strip, far);
  now.clearness = std::clamp((now.way - 0.6) / (3 - 0.6), 0.0, 1.0);
  now.since += seconds;
  Steering next = Steering::forward, label = Steering::forward;
  const bool turns_now = now.way < (now.steering == Steering::forward ? near : clear);
  const Turns turns = turns_now || now.way < label_near ? look_round(plan, robot) : Turns{};
  if (now.way < label_near) label = side_in_view(turns);
  if (turns_now) {
    const double shorter = turns.right - turns.left;  // to the left
    const bool left = now.steering == Steering::forward     ? (std::abs(shorter) > alike ? shorter > 0 : turns.lean > 0)
                      : now.steering == Steering::turn_left ? shorter > -much
                                                            : shorter > much;
    next = left ? Steering::turn_left : Steering::turn_right;
  }
  if (label != now.label) {
    now.since = 0;
    ++now.changes;
  }
  now.steering = next;
  now.label = label;
  return now;
}

void Expert::choose_mood() {
  mood_ = Mood::sober;
  mood_left_ = chance_.between(1.5, 5);
  if (chance_.between(0, 1) >= exploration_) return;
  mood_ = static_cast<Mood>(1 + chance_.below(3));
  mood_left_ = chance_.between(0.8, 2.5);
  mood_speed_ = chance_.between(0.2, 0.5);
  mood_turn_ = (chance_.below(2) ? 1 : -1) * chance_.between(0.2, 0.9);
}

Order Expert::drive(const FloorPlan& plan, const Robot& robot, double seconds) {
  mood_left_ -= seconds;
  if (mood_left_ <= 0) choose_mood();
  const bool forward = judgement_.steering == Steering::forward;
  Order order{false, forward ? speed * std::clamp(0.4 + 1.5 * judgement_.clearness, 0.0, 1.0) : 0, 0};
  if (!forward) order.turn_rate = judgement_.steering == Steering::turn_left ? turn : -turn;
  if (mood_ == Mood::swing) order = {false, mood_speed_, mood_turn_};
  if (mood_ == Mood::push) order = {false, mood_speed_, 0.3 * mood_turn_};
  if (mood_ == Mood::spin) order = {false, 0, mood_turn_};
  // Where it would come to stand, and half way there.
  const double most = std::max(order.speed, robot.speed()), reach = most * (seconds + 0.05) + most * most / (2 * Robot::braking) + 0.03;
  const Spot along = towards(robot.heading + order.turn_rate * seconds / 2);
  for (const double part : {0.5, 1.0}) {
    const Spot there{robot.spot.x + along.x * reach * part, robot.spot.z + along.z * reach * part};
    if (order.speed <= 0 || plan.gap(there, room) >= room) continue;
    order.speed = 0;
    if (mood_ == Mood::push || mood_ == Mood::swing) mood_left_ = 0;
    if (order.turn_rate == 0 || mood_ == Mood::push) order.turn_rate = forward ? turn : order.turn_rate;
  }
  return order;
}

}  // namespace vdisp::sim
