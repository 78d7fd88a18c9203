// wheels.cpp: the arithmetic of a differential drive.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/wheels.h"

#include <algorithm>
#include <cmath>

namespace vdisp::drive {

Wheels wheels_for(double speed, double turn_rate, double base) { return {speed - turn_rate * base / 2, speed + turn_rate * base / 2}; }

double speed_of(const Wheels& wheels) { return (wheels.left + wheels.right) / 2; }

double turn_rate_of(const Wheels& wheels, double base) { return (wheels.right - wheels.left) / base; }

Wheels limited(Wheels wheels, double most) {
  const double fastest = std::max(std::abs(wheels.left), std::abs(wheels.right));
  if (fastest <= most) return wheels;
  return {wheels.left * most / fastest, wheels.right * most / fastest};
}

/// How far a wheel may change: through zero it is slowed first, and sped up for what is left of the time.
double Ramp::allowed(double from, double to, double seconds, double slowing) const {
  if (from * (to - from) >= 0) return speeding_ * seconds;
  const double to_stand = std::abs(from) / slowing;
  if (to_stand >= seconds) return slowing * seconds;
  return std::abs(from) + speeding_ * (seconds - to_stand);
}

const Wheels& Ramp::step(const Wheels& target, double seconds, double slowing) {
  const auto part = [&](double from, double to) {
    return from == to ? 1.0 : std::min(1.0, allowed(from, to, seconds, slowing) / std::abs(to - from));
  };
  const double both = std::min(part(now_.left, target.left), part(now_.right, target.right));
  if (both >= 1) {
    now_ = target;
  } else {
    now_.left += both * (target.left - now_.left);
    now_.right += both * (target.right - now_.right);
  }
  return now_;
}

}  // namespace vdisp::drive
