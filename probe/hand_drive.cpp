// hand_drive.cpp: keys before the gamepad before the mouse.
// SPDX-License-Identifier: Apache-2.0
#include "probe/hand_drive.h"

#include "probe/format.h"

namespace vdisp {
namespace {
constexpr std::chrono::milliseconds period{50};
}

std::optional<HandOrder> order_of(const Hands& hands, double speed, double turn_rate) {
  if (!hands.focus) return {};
  if (hands.down) return HandOrder{0, 0};
  const int side = hands.left - hands.right;
  if (hands.up || hands.left || hands.right) return HandOrder{hands.up ? speed : 0, side * turn_rate};
  if (hands.stick) return HandOrder{hands.stick_ahead * speed, hands.stick_left * turn_rate};
  if (!hands.mouse) return {};
  const int turn = hands.mouse_left - hands.mouse_right;
  if (hands.mouse_left && hands.mouse_right) return HandOrder{0, 0};
  return HandOrder{turn ? 0 : speed, turn * turn_rate};
}

void HandDrive::tick(const Hands& hands, Clock::time_point now) {
  const std::optional<HandOrder> order = order_of(hands, speed_, turn_rate_);
  if (!order) {
    words_ = "no order";
    label_ = Label::none;
    return;
  }
  // A stick that trembles has another order at each look; only to stand is urgent.
  const bool urgent = *order == HandOrder{} && sent_ != HandOrder{};
  if (now - sent_at_ < period && !urgent) return;
  sent_ = *order;
  sent_at_ = now;
  label_ = label_of(order->speed, order->turn_rate);
  const bool through = control_.drive(order->speed, order->turn_rate) == Control::Result::done;
  words_ = !through ? "no order gets through: " + control_.message()
                    : std::string(label_ == Label::none ? "stand" : name(label_)) +
                          format("  %+.2f m/s  %+.2f rad/s", order->speed, order->turn_rate);
}

}  // namespace vdisp
