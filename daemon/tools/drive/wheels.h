// wheels.h: from speed and turn rate to the two wheels of a differential drive, and how fast they may change.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdisp::drive {

/// Speeds over ground of the two driven wheels, m/s, positive ahead.
struct Wheels {
  double left = 0, right = 0;
  bool operator==(const Wheels&) const = default;
};

/// `base`: distance of the wheels, m. A turn to the left (rad/s, positive) makes the right wheel faster.
Wheels wheels_for(double speed, double turn_rate, double base);
double speed_of(const Wheels& wheels);
double turn_rate_of(const Wheels& wheels, double base);

/// Neither wheel faster than `most`; both slowed by one factor, so that the curve stays the one that was ordered.
Wheels limited(Wheels wheels, double most);

/// Brings the wheels to what is ordered, no faster than the limits (m/s^2) allow. Both change by one factor of what is missing, so that
/// they arrive together.
class Ramp {
 public:
  /// `speeding`: away from a stand; `slowing`: towards it.
  Ramp(double speeding, double slowing) : speeding_(speeding), slowing_(slowing) {}
  const Wheels& now() const { return now_; }
  const Wheels& step(const Wheels& target, double seconds) { return step(target, seconds, slowing_); }
  const Wheels& step(const Wheels& target, double seconds, double slowing);
  void stand() { now_ = {}; }

 private:
  double allowed(double from, double to, double seconds, double slowing) const;

  double speeding_, slowing_;
  Wheels now_;
};

}  // namespace vdisp::drive
