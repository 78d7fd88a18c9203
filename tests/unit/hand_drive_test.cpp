// hand_drive_test.cpp: what is held is what is ordered, and without focus nothing is.
// SPDX-License-Identifier: Apache-2.0
#include "probe/hand_drive.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/standin_control.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

using std::chrono::milliseconds;

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

struct HandOrders : testing::Test {
  TemporaryFolder folder;
  StandInControl daemon{(folder / "control").string()};
  Control control{(folder / "control").string()};
  HandDrive drive{control, 0.4, 0.8};
  HandDrive::Clock::time_point now = HandDrive::Clock::now();

  /// As often as the window's loop looks, for a second.
  template <class Held>
  void second_of(const Held& held) {
    for (int i = 0; i < 250; ++i) drive.tick(held(i), now += milliseconds(4));
  }
  static Hands stick(double ahead) {
    Hands hands;
    hands.focus = hands.stick = true;
    hands.stick_ahead = ahead;
    return hands;
  }
  std::vector<double> speeds() {
    std::vector<double> all;
    for (const auto& heard : daemon.hear()) {
      DriveMessage message;
      std::memcpy(&message, heard.bytes.data(), sizeof message);
      EXPECT_EQ(message.header.type, CommandType::drive);
      all.push_back(message.speed);
    }
    return all;
  }
};

TEST_F(HandOrders, what_is_held_goes_out_20_times_a_second_steady_or_trembling) {
  second_of([](int) { return stick(0.5); });
  EXPECT_NEAR(daemon.count(CommandType::drive), 20, 1);
  second_of([](int i) { return stick(0.5 + 0.001 * (i % 7)); });
  EXPECT_NEAR(daemon.count(CommandType::drive), 20, 1) << "another order at each look";
  second_of([](int i) { return i % 2 ? stick(0.1) : Hands{}; });
  EXPECT_LE(daemon.count(CommandType::drive), 21) << "at the edge of its middle";
}

TEST_F(HandOrders, of_what_trembles_the_newest_is_sent_when_the_time_has_come) {
  for (int i = 0; i < 14; ++i) drive.tick(stick(0.1 * (i + 1) / 1.4), now + milliseconds(4 * i));
  const std::vector<double> sent = speeds();
  ASSERT_EQ(sent.size(), 2u);
  EXPECT_NEAR(sent[0], 0.4 * 0.1 / 1.4, 1e-12);
  EXPECT_NEAR(sent[1], 0.4, 1e-12) << "of 52 ms";
}

TEST_F(HandOrders, an_order_to_stand_does_not_wait) {
  Hands hands = stick(0.5);
  drive.tick(hands, now);
  hands.down = true;
  drive.tick(hands, now + milliseconds(4));
  EXPECT_EQ(speeds(), (std::vector<double>{0.2, 0}));
  drive.tick(hands, now + milliseconds(8));
  EXPECT_EQ(speeds().size(), 0u) << "once is enough";
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
