// hand_drive_test.cpp: what is held is what is ordered, and without focus nothing is.
// SPDX-License-Identifier: Apache-2.0
#include "probe/hand_drive.h"

#include <gtest/gtest.h>

namespace vdisp {
namespace {

std::optional<HandOrder> order(const Hands& hands) { return order_of(hands, 0.4, 0.8); }

TEST(HandDrive, arrow_keys_go_ahead_and_turn_on_the_spot) {
  Hands hands;
  hands.focus = true;
  EXPECT_EQ(order(hands), std::nullopt);
  hands.up = true;
  EXPECT_EQ(order(hands), (HandOrder{0.4, 0}));
  hands.left = true;
  EXPECT_EQ(order(hands), (HandOrder{0.4, 0.8}));
  hands.up = false;
  EXPECT_EQ(order(hands), (HandOrder{0, 0.8}));
  hands.right = true;
  EXPECT_EQ(order(hands), (HandOrder{0, 0}));
  hands.down = hands.up = true;
  EXPECT_EQ(order(hands), (HandOrder{0, 0})) << "to stand goes before all";
}

TEST(HandDrive, by_mouse_a_button_turns_and_none_is_ahead_as_in_the_paper) {
  Hands hands;
  hands.focus = hands.mouse = true;
  EXPECT_EQ(order(hands), (HandOrder{0.4, 0}));
  hands.mouse_left = true;
  EXPECT_EQ(order(hands), (HandOrder{0, 0.8}));
  hands.mouse_left = false, hands.mouse_right = true;
  EXPECT_EQ(order(hands), (HandOrder{0, -0.8}));
  hands.mouse = hands.mouse_right = false;
  EXPECT_EQ(order(hands), std::nullopt);
}

TEST(HandDrive, a_stick_gives_parts_of_both) {
  Hands hands;
  hands.focus = hands.stick = true;
  hands.stick_ahead = 0.5, hands.stick_left = -0.25;
  EXPECT_EQ(order(hands), (HandOrder{0.2, -0.2}));
}

TEST(HandDrive, without_focus_nothing_is_ordered) {
  Hands hands;
  hands.up = hands.mouse = hands.stick = hands.mouse_left = true;
  EXPECT_EQ(order(hands), std::nullopt);
}

TEST(HandDrive, says_when_no_order_gets_through) {
  Control control("/nowhere/control", std::chrono::milliseconds(20));
  HandDrive drive(control, 0.4, 0.8);
  Hands hands;
  hands.focus = hands.up = true;
  drive.tick(hands, HandDrive::Clock::now());
  EXPECT_EQ(drive.words().find("no order gets through"), 0u) << drive.words();
  EXPECT_EQ(drive.label(), Label::forward);
  drive.tick({}, HandDrive::Clock::now());
  EXPECT_EQ(drive.words(), "no order");
  EXPECT_EQ(drive.label(), Label::none);
}

}  // namespace
}  // namespace vdisp
