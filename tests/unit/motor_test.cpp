// motor_test.cpp: the parts of vdisp-drive: phrases, the arithmetic of wheels, limits, replies, and which orders count.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "daemon/tools/drive/motors.h"
#include "daemon/tools/drive/orders.h"
#include "daemon/tools/drive/phrase.h"
#include "daemon/tools/drive/replies.h"
#include "daemon/tools/drive/settings.h"
#include "daemon/tools/drive/wheels.h"

namespace vdisp::drive {
namespace {

std::string said(const std::string& text, const Motion& motion = {}) {
  char bytes[64];
  return std::string(bytes, Phrase(text).fill(motion, bytes));
}

std::string complaint(const std::string& text) {
  try {
    Phrase phrase(text);
  } catch (const PhraseError& error) {
    return error.what();
  }
  return "";
}

TEST(Phrase, fields_are_filled_with_as_many_decimals_as_asked) {
  const Motion motion{-123.6, 45.4, 0.25, -1.5};
  EXPECT_EQ(said("!M {left} {right}\\r", motion), "!M -124 45\r");
  EXPECT_EQ(said("{speed},{turn}", motion), "0.250,-1.500");
  EXPECT_EQ(said("{left:.2};{speed:.0};{turn:.1}", motion), "-123.60;0;-1.5");
}

TEST(Phrase, zero_has_no_sign) {
  EXPECT_EQ(said("{left} {right:.1}", {-0.3, -0.04, 0, 0}), "0 0.0");
  EXPECT_EQ(said("{left:.1} {right:.1}", {-0.3, -0.06, 0, 0}), "-0.3 -0.1");
  EXPECT_EQ(said("{speed}", {0, 0, -0.0, 0}), "0.000");
}

TEST(Phrase, escapes_and_braces_are_bytes) {
  EXPECT_EQ(said("a\\r\\n\\t\\\\\\x7e{{}}"), "a\r\n\t\\~{}");
  EXPECT_EQ(said(std::string("\\x00\\xfF")), std::string("\0\xff", 2));
}

TEST(Phrase, what_is_wrong_is_said_with_what_would_be_right) {
  EXPECT_NE(complaint("{lft}").find("no field {lft}, must be {left}, {right}, {speed} or {turn}"), std::string::npos);
  EXPECT_NE(complaint("{}").find("no field {}"), std::string::npos);
  EXPECT_NE(complaint("{left").find("is missing"), std::string::npos);
  EXPECT_NE(complaint("left}").find("}}"), std::string::npos);
  EXPECT_NE(complaint("{left:2}").find("{left:.2}"), std::string::npos);
  EXPECT_NE(complaint("{left:.7}").find("0 to 6"), std::string::npos);
  for (const char* bad : {"\\q", "\\", "\\x1", "\\xg0", "\\x"}) EXPECT_NE(complaint(bad).find("no escape"), std::string::npos) << bad;
  EXPECT_EQ(complaint("no fields at all"), "");
}

TEST(Phrase, what_does_not_fit_is_not_said_in_part) {
  char small[8];
  EXPECT_EQ(Phrase("{left} {right}").fill({100, 100, 0, 0}, small), 7u);
  EXPECT_EQ(Phrase("{left} {right}").fill({1000, 1000, 0, 0}, small), 0u);
  EXPECT_EQ(Phrase("longer than that").fill({}, small), 0u);
}

TEST(Phrase, bytes_are_shown_as_people_read_them) {
  EXPECT_EQ(escaped(std::string("!M 0\\\r\n\x1b\xff\0", 10)), "!M 0\\\\\\r\\n\\x1b\\xff\\x00");
}

TEST(Wheels, a_turn_to_the_left_makes_the_right_wheel_faster) {
  const Wheels wheels = wheels_for(0.5, 1, 0.4);
  EXPECT_DOUBLE_EQ(wheels.left, 0.3);
  EXPECT_DOUBLE_EQ(wheels.right, 0.7);
  EXPECT_DOUBLE_EQ(speed_of(wheels), 0.5);
  EXPECT_DOUBLE_EQ(turn_rate_of(wheels, 0.4), 1);
}

TEST(Wheels, driven_in_small_steps_they_make_the_circle_that_was_ordered) {
  const double speed = 0.5, turn = 0.8, base = 0.35, dt = 1e-4;
  const Wheels wheels = wheels_for(speed, turn, base);
  double x = 0, y = 0, yaw = 0;
  for (double t = 0; t < std::numbers::pi / turn; t += dt) {  // half a turn: across the circle, speed / turn to the left of the start
    x += (wheels.left + wheels.right) / 2 * std::cos(yaw) * dt;
    y += (wheels.left + wheels.right) / 2 * std::sin(yaw) * dt;
    yaw += (wheels.right - wheels.left) / base * dt;
  }
  EXPECT_NEAR(x, 0, 1e-3);
  EXPECT_NEAR(y, 2 * speed / turn, 1e-3);
}

TEST(Wheels, the_limit_keeps_the_curve) {
  const Wheels ordered = wheels_for(2, 3, 0.4), wheels = limited(ordered, 0.8);
  EXPECT_DOUBLE_EQ(std::max(wheels.left, wheels.right), 0.8);
  EXPECT_NEAR(turn_rate_of(wheels, 0.4) / speed_of(wheels), 3.0 / 2, 1e-12);
  EXPECT_EQ(limited({-0.8, 0.8}, 0.8), (Wheels{-0.8, 0.8}));
  EXPECT_DOUBLE_EQ(limited({-4, 2}, 1).left, -1);
  EXPECT_DOUBLE_EQ(limited({-4, 2}, 1).right, 0.5);
}

TEST(Ramp, speeds_up_and_slows_down_by_its_limits) {
  Ramp ramp(0.5, 2);
  for (int i = 1; i <= 20; ++i) EXPECT_NEAR(ramp.step({0.5, 0.5}, 0.05).left, std::min(0.5, i * 0.025), 1e-12) << i;
  for (int i = 1; i <= 3; ++i) EXPECT_NEAR(ramp.step({0.1, 0.1}, 0.05).right, std::max(0.1, 0.5 - i * 0.1), 1e-12) << i;
  ramp.stand();
  EXPECT_EQ(ramp.now(), Wheels{});
}

TEST(Ramp, wheels_arrive_together) {
  Ramp ramp(1, 1);
  for (int i = 0; i < 9; ++i) {
    const Wheels now = ramp.step({0.5, 1}, 0.1);
    EXPECT_NEAR(now.left / now.right, 0.5, 1e-12);
    EXPECT_NEAR(now.right, (i + 1) * 0.1, 1e-12);
  }
  EXPECT_EQ(ramp.step({0.5, 1}, 0.11), (Wheels{0.5, 1}));
}

TEST(Ramp, through_zero_a_wheel_is_slowed_first_and_then_sped_up) {
  Ramp ramp(1, 4);
  ramp.step({0.2, 0.2}, 1);
  // 0.2 m/s take 0.05 s to stand, the other 0.05 s make 0.05 m/s backwards.
  EXPECT_NEAR(ramp.step({-1, -1}, 0.1).left, -0.05, 1e-12);
  EXPECT_NEAR(ramp.step({-1, -1}, 0.1).left, -0.15, 1e-12);
}

TEST(Ramp, no_step_is_larger_than_the_limits_whatever_is_ordered) {
  Ramp ramp(0.7, 1.9);
  uint32_t seed = 1;
  const auto chance = [&] { return static_cast<double>((seed = seed * 1664525 + 1013904223) >> 8) / (1 << 23) - 1; };
  for (int i = 0; i < 10000; ++i) {
    const Wheels before = ramp.now(), after = ramp.step({chance(), chance()}, 0.05);
    for (const auto& [a, b] : {std::pair{before.left, after.left}, std::pair{before.right, after.right}}) {
      const double slowed = std::max(0.0, std::abs(a) - (a * b > 0 ? std::abs(b) : 0)), sped = std::abs(b) - (a * b > 0 ? std::abs(a) : 0);
      EXPECT_LE(slowed / 1.9 + std::max(0.0, sped) / 0.7, 0.05 + 1e-9);
    }
  }
}

constexpr int64_t ms = 1'000'000;

TEST(Replies, three_right_lines_are_believed_and_silence_is_not) {
  Replies replies("\\+|OK [0-9]+", 300 * ms);
  replies.forget(0);
  EXPECT_EQ(replies.judge(0), Hearing::silent);
  replies.take("+\r", 10 * ms);
  replies.take("\r\nOK 1", 20 * ms);
  EXPECT_EQ(replies.judge(20 * ms), Hearing::silent);
  replies.take("2\n+\r", 30 * ms);
  EXPECT_EQ(replies.judge(30 * ms), Hearing::good);
  EXPECT_EQ(replies.judge(330 * ms), Hearing::good);
  EXPECT_EQ(replies.judge(331 * ms), Hearing::silent);
  replies.take("+\r", 340 * ms);
  EXPECT_EQ(replies.judge(340 * ms), Hearing::silent);
  replies.take("+\r+\r", 350 * ms);
  EXPECT_EQ(replies.judge(350 * ms), Hearing::good);
  EXPECT_EQ(replies.right_lines(), 6u);
}

TEST(Replies, three_wrong_lines_in_a_row_are_rubbish_one_is_noise) {
  Replies replies("\\+", 300 * ms);
  replies.forget(0);
  replies.take("+\r+\r+\r", 0);
  EXPECT_EQ(replies.judge(0), Hearing::good);
  replies.take("?\r?\r", 1);
  EXPECT_EQ(replies.judge(1), Hearing::good);
  replies.take("+\r-\r-\r", 2);
  EXPECT_EQ(replies.judge(2), Hearing::good);
  replies.take("-!\r", 3);
  EXPECT_EQ(replies.judge(3), Hearing::rubbish);
  EXPECT_EQ(replies.wrong(), "-!");
  EXPECT_EQ(replies.wrong_lines(), 5u);
  replies.take("+\r+\r+\r", 4);
  EXPECT_EQ(replies.judge(4), Hearing::good);
}

TEST(Replies, the_pattern_is_of_the_whole_line) {
  Replies replies("a|b", 300 * ms);
  replies.take("ab\rxa\rbx\ra\rb\r", 0);
  EXPECT_EQ(replies.right_lines(), 2u);
  EXPECT_EQ(replies.wrong_lines(), 3u);
}

TEST(Replies, rubbish_without_line_ends_is_noticed_and_not_kept) {
  Replies replies("\\+", 300 * ms);
  replies.forget(0);
  replies.take("+\r+\r+\r", 0);
  replies.take(std::string(1000, '\0'), 1);
  EXPECT_EQ(replies.judge(1), Hearing::rubbish);
  EXPECT_EQ(replies.wrong_lines(), 7u);
  EXPECT_LT(replies.wrong().size(), 200u);
}

TEST(Replies, without_a_pattern_nothing_is_expected) {
  Replies replies("", 300 * ms);
  replies.take("rubbish\rrubbish\rrubbish\r", 0);
  EXPECT_EQ(replies.judge(1'000'000 * ms), Hearing::not_asked);
  EXPECT_EQ(replies.wrong_lines(), 0u);
}

TEST(Replies, a_bad_pattern_is_refused) { EXPECT_THROW(Replies("(", 0), std::invalid_argument); }

/// A drive order as it lies in shared memory.
struct Given {
  Given()
      : memory(new (std::align_val_t(64)) std::byte[record_spec<DriveCommand>().bytes()]),
        image(*Image::make(memory, record_spec<DriveCommand>())) {
    DriveCommand& command = make_record<DriveCommand>(image);
    command.speed = 0.4;
    command.turn_rate = -0.2;
  }
  ~Given() { operator delete[](memory, std::align_val_t(64)); }
  Order judged(double age_s = 0.01, bool synthetic_allowed = false, Trust trust = Trust::fresh) {
    return judge(vdisp::Reading{&image, trust, image.reason, age_s}, 0.3, synthetic_allowed, now_ns);
  }
  std::byte* memory;
  Image& image;
  int64_t now_ns = 5000 * ms;
};

TEST(Orders, one_that_ends_is_over_then_however_young_it_is) {
  Given given;
  DriveCommand& command = *given.image.row<DriveCommand>(0);
  command.valid_until_ns = given.now_ns + 1;
  EXPECT_EQ(given.judged().halt, Halt::none);
  command.valid_until_ns = given.now_ns;
  EXPECT_EQ(given.judged().halt, Halt::over);
  EXPECT_EQ(given.judged().speed, 0);
  command.valid_until_ns = 0;
  EXPECT_EQ(given.judged().halt, Halt::none) << "no end of its own";
}

TEST(Orders, a_fresh_one_is_driven_by) {
  Given given;
  const Order order = given.judged();
  EXPECT_EQ(order.halt, Halt::none);
  EXPECT_EQ(order.speed, 0.4);
  EXPECT_EQ(order.turn_rate, -0.2);
}

TEST(Orders, each_reason_not_to_drive_is_told_and_leaves_no_speed) {
  const auto halted = [](const Order& order, Halt why) { return order.halt == why && order.speed == 0 && order.turn_rate == 0; };
  Given given;
  EXPECT_TRUE(halted(given.judged(0.301), Halt::stale));
  EXPECT_TRUE(halted(given.judged(0.01, false, Trust::dead), Halt::dead));
  EXPECT_TRUE(halted(judge({}, 0.3, true, 0), Halt::dead));
  EXPECT_TRUE(halted(judge(vdisp::Reading{nullptr, Trust::stale, Reason::none, 0}, 0.3, true, 0), Halt::stale));
  EXPECT_TRUE(halted(given.judged(-0.5), Halt::nonsense));
  given.image.set_blind(Reason::too_dark);
  EXPECT_TRUE(halted(given.judged(), Halt::blind));
  EXPECT_EQ(given.judged().reason, Reason::too_dark);
}

TEST(Orders, the_timeout_is_the_configurations_not_the_librarys) {
  Given given;
  EXPECT_EQ(given.judged(0.29, false, Trust::stale).halt, Halt::none);
  EXPECT_EQ(judge(vdisp::Reading{&given.image, Trust::fresh, Reason::none, 0.2}, 0.1, false, 0).halt, Halt::stale);
}

TEST(Orders, synthetic_ones_are_refused_unless_allowed) {
  Given given;
  given.image.flags = flag_synthetic | flag_held;
  EXPECT_EQ(given.judged().halt, Halt::synthetic);
  EXPECT_EQ(given.judged(0.01, true).halt, Halt::none);
}

TEST(Orders, what_is_no_number_or_no_order_is_refused) {
  Given given;
  DriveCommand& command = *given.image.row<DriveCommand>(0);
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    command.speed = bad;
    EXPECT_EQ(given.judged().halt, Halt::nonsense);
    command.speed = 0;
    command.turn_rate = bad;
    EXPECT_EQ(given.judged().halt, Halt::nonsense);
    command.turn_rate = 0;
  }
  command.header.version = 99;
  EXPECT_EQ(given.judged().halt, Halt::nonsense);
}

TEST(Settings, a_text_that_is_too_long_to_be_said_is_refused_whichever_it_is) {
  for (const char* key : {"command", "stop", "start"}) {
    Config config;
    const auto refused = [&](size_t length) {
      // The longest of its kind is "-1000-1000".
      const std::string text = key == std::string("command") ? "{left}{right}" + std::string(length - 10, 'x') : std::string(length, 'x');
      (key == std::string("stop") ? config.drive.stop : key == std::string("start") ? config.drive.start : config.drive.command) = text;
      std::vector<std::string> complaints;
      read_settings(config, "/dev/ttyS0", complaints);
      return complaints.size() == 1 && complaints[0].find(std::string(key) + ": longer than 256 bytes") != std::string::npos;
    };
    EXPECT_FALSE(refused(longest_command)) << key;
    EXPECT_TRUE(refused(longest_command + 1)) << key;
    EXPECT_TRUE(refused(3000)) << key;
  }
}

TEST(Motors, what_has_no_bytes_has_not_been_said) {
  Settings settings;
  settings.from.port = "-";
  settings.stop = Phrase(std::string(longest_command + 1, 'x'));
  settings.period_ns = 50 * ms;
  Motors motors(settings);
  motors.serve({}, true, 1000 * ms);
  motors.serve({}, true, 1100 * ms);
  EXPECT_FALSE(motors.standing());
}

TEST(Settings, wheels_become_the_controllers_units_and_directions) {
  Settings settings;
  settings.from.wheelScale = 100;
  settings.from.wheelBase = 0.5;
  settings.from.reverse = "left";
  const Motion motion = settings.motion({0.2, 0.4});
  EXPECT_DOUBLE_EQ(motion.left, -20);
  EXPECT_DOUBLE_EQ(motion.right, 40);
  EXPECT_DOUBLE_EQ(motion.speed, 0.3);
  EXPECT_DOUBLE_EQ(motion.turn, 0.4);
  settings.from.reverse = "both";
  EXPECT_DOUBLE_EQ(settings.motion({0.2, 0.4}).right, -40);
}

TEST(Settings, the_defaults_need_nothing_but_a_port) {
  std::vector<std::string> complaints;
  const Settings settings = read_settings(Config{}, "/dev/ttyS0", complaints);
  EXPECT_TRUE(complaints.empty());
  EXPECT_EQ(settings.period_ns, 50 * ms);
  read_settings(Config{}, "", complaints);
  ASSERT_EQ(complaints.size(), 1u);
  EXPECT_NE(complaints[0].find("[drive] port"), std::string::npos);
}

}  // namespace
}  // namespace vdisp::drive
