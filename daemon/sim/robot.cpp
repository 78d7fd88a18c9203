// robot.cpp: a differential drive with limits.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/robot.h"

#include <algorithm>

namespace vdisp::sim {
namespace {

double nearer(double now, double wanted, double seconds) {
  const bool slows = std::abs(wanted) < std::abs(now) || wanted * now < 0;
  const double most = (slows ? Robot::braking : Robot::speeding) * seconds;
  return std::clamp(wanted, now - most, now + most);
}

}  // namespace

void Robot::move(const Order& order, double seconds) {
  const bool told = !order.brake && std::isfinite(order.speed) && std::isfinite(order.turn_rate);
  const double ahead = told ? std::clamp(order.speed, -most_back, most_wheel_speed) : 0;
  const double turn = told ? std::clamp(order.turn_rate, -most_turn, most_turn) * wheel_base / 2 : 0;
  // Too fast for a wheel: slower, on the same curve.
  const double scale = std::max(1.0, (std::abs(ahead) + std::abs(turn)) / most_wheel_speed);
  left_ = nearer(left_, (ahead - turn) / scale, seconds);
  right_ = nearer(right_, (ahead + turn) / scale, seconds);
  const double turned = turn_rate() * seconds;
  const Spot along = towards(heading + turned / 2);
  spot.x += along.x * speed() * seconds;
  spot.z += along.z * speed() * seconds;
  heading = std::remainder(heading + turned, 2 * M_PI);
}

}  // namespace vdisp::sim
