// hand_drive.h: what hands on keys, mouse or gamepad mean for the rover, and when they mean nothing any more.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "ipc/include/vdisp/control.h"
#include "ipc/recorded_step.h"
#include "probe/view/hands.h"

namespace vdisp {

struct HandOrder {
  double speed = 0, turn_rate = 0;  ///< m/s, rad/s to the left
  bool operator==(const HandOrder&) const = default;
};

/// The order that is held; nothing: none, the rover is left to itself (and its detectors). Left and right turn on the spot, as the paper
/// drives: by mouse the rover goes ahead while no button is held. Down is an order to stand.
std::optional<HandOrder> order_of(const Hands& hands, double speed, double turn_rate);

/// Sends what is held to the daemon, 20 times a second, the newest each time; an order to stand at once. What is let go is not sent any
/// more: the daemon forgets it after 300 ms.
class HandDrive {
 public:
  using Clock = std::chrono::steady_clock;
  HandDrive(Control& control, double speed, double turn_rate) : control_(control), speed_(speed), turn_rate_(turn_rate) {}

  void tick(const Hands& hands, Clock::time_point now);
  /// For the window: "forward 0.30 m/s", "no order", or why it did not get through.
  const std::string& words() const { return words_; }
  Label label() const { return label_; }

 private:
  Control& control_;
  double speed_, turn_rate_;
  HandOrder sent_;
  Clock::time_point sent_at_{};
  std::string words_ = "no order";
  Label label_ = Label::none;
};

}  // namespace vdisp
