// steering.h: part of `decision`: the paper's three states (census + SNoW, figure 10), and what a detector tells them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "ipc/records.h"

namespace vdisp {

/// What a detector says of the way ahead.
struct Way {
  bool free = false;
  bool left = true;      ///< where to evade; asked only where it is not free
  double clearness = 0;  ///< 0 = as near as the rover may come, 1 = nothing is near
};

/// Forward while the way is free; else left or right, as the detector says in that moment, until it is free again.
///
/// More than figure 10: a turn that begins within `hold` of the last one goes the same way, or a corner would never be left. And a turn
/// ends only where the way is `clear_enough`: ended at the first view that is just free, it would creep on and turn again a step later.
/// What is enough becomes less the longer the turn lasts, blind frames included, down to any free way after `patience_s`, half a circle at
/// the default rate: in a narrow place there is no better.
class SteeringMachine {
 public:
  static constexpr double patience_s = 4;
  /// The state after a frame taken at `now_ns`. clear_enough: 0 to 1, as Way::clearness.
  Steering step(const Way& way, int64_t now_ns, double hold_s, double clear_enough) noexcept {
    if (steps_++ == 0 || now_ns < last_ns_) since_ns_ = now_ns, turned_ns_ = std::min(turned_ns_, now_ns);
    last_ns_ = now_ns;
    const bool ahead = steering_ == Steering::forward;
    if (way.free && (ahead || way.clearness >= clear_enough * (1 - since_s() / patience_s))) {
      if (steering_ != Steering::forward) turned_ = steering_, turned_ns_ = now_ns;
      change(Steering::forward, now_ns);
    } else if (ahead) {
      const bool held = turned_ != Steering::forward && static_cast<double>(now_ns - turned_ns_) < hold_s * 1e9;
      change(held ? turned_ : way.left ? Steering::turn_left : Steering::turn_right, now_ns);
    }
    return steering_;
  }
  double since_s() const noexcept { return static_cast<double>(last_ns_ - since_ns_) * 1e-9; }
  uint64_t changes() const noexcept { return changes_; }

 private:
  void change(Steering to, int64_t now_ns) noexcept {
    if (to == steering_) return;
    steering_ = to;
    since_ns_ = now_ns;
    ++changes_;
  }

  Steering steering_ = Steering::forward;
  Steering turned_ = Steering::forward;  // the last turn; forward: there was none
  int64_t last_ns_ = 0, since_ns_ = 0, turned_ns_ = 0;
  uint64_t steps_ = 0, changes_ = 0;
};

}  // namespace vdisp
