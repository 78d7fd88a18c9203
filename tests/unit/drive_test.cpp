// drive_test.cpp: from what the detectors say to speed and turn rate: the state machine, the cross-check, the command.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/drive.h"

#include <gtest/gtest.h>

#include "daemon/stages/cross_check.h"
#include "daemon/stages/decide.h"
#include "tests/support/count_allocations.h"
#include "tests/unit/way_map.h"

namespace vdisp {
namespace {

constexpr int64_t ms = 1'000'000;
constexpr Way free_way{true, true, 1}, left_of_it{false, true, 0}, right_of_it{false, false, 0};

TEST(SteeringMachine, turns_where_the_detector_says_and_holds_it_until_the_way_is_free) {
  SteeringMachine machine;
  int64_t now = 0;
  const auto step = [&](const Way& way) { return machine.step(way, now += 100 * ms, 0, 0); };
  EXPECT_EQ(step(free_way), Steering::forward);
  EXPECT_EQ(step(right_of_it), Steering::turn_right);
  EXPECT_EQ(step(left_of_it), Steering::turn_right) << "the direction is held";
  EXPECT_EQ(step(left_of_it), Steering::turn_right);
  EXPECT_NEAR(machine.since_s(), 0.2, 1e-9);
  EXPECT_EQ(step(free_way), Steering::forward);
  EXPECT_EQ(step(left_of_it), Steering::turn_left);
  EXPECT_EQ(machine.changes(), 3u);
}

TEST(SteeringMachine, begins_with_what_it_sees_first) {
  SteeringMachine machine;
  EXPECT_EQ(machine.step(left_of_it, 5000 * ms, 1, 0), Steering::turn_left);
  EXPECT_EQ(machine.since_s(), 0) << "not since the clock began";
}

TEST(SteeringMachine, a_turn_soon_after_another_goes_the_same_way) {
  SteeringMachine machine;
  machine.step(right_of_it, 0, 1, 0);
  machine.step(free_way, 1000 * ms, 1, 0);
  EXPECT_EQ(machine.step(left_of_it, 1900 * ms, 1, 0), Steering::turn_right);
  machine.step(free_way, 2000 * ms, 1, 0);
  EXPECT_EQ(machine.step(left_of_it, 3000 * ms, 1, 0), Steering::turn_left) << "a second is over";
}

TEST(SteeringMachine, a_turn_ends_where_the_way_is_clear_enough_and_less_is_enough_the_longer_it_lasts) {
  const auto steers = [](double clearness, int64_t at) {
    SteeringMachine machine;
    machine.step(left_of_it, 0, 1, 0.4);
    return machine.step({.free = true, .clearness = clearness}, at, 1, 0.4);
  };
  EXPECT_EQ(steers(0.41, 0), Steering::forward);
  EXPECT_EQ(steers(0.39, 0), Steering::turn_left);
  EXPECT_EQ(steers(0.21, 2000 * ms), Steering::forward) << "half of 4 s";
  EXPECT_EQ(steers(0.19, 2000 * ms), Steering::turn_left);
  EXPECT_EQ(steers(0, 4000 * ms), Steering::forward) << "half a circle: there is no better way";
  SteeringMachine machine;
  EXPECT_EQ(machine.step({.free = true, .clearness = 0}, 0, 1, 0.4), Steering::forward) << "ahead, any free way is driven";
}

TEST(SteeringMachine, time_may_begin_anew) {
  SteeringMachine machine;
  machine.step(right_of_it, 9000 * ms, 1, 0);
  machine.step(free_way, 9100 * ms, 1, 0);
  machine.step(free_way, 0, 1, 0);
  EXPECT_EQ(machine.since_s(), 0);
  EXPECT_EQ(machine.step(left_of_it, 5000 * ms, 1, 0), Steering::turn_left);
}

/// Decision, cross-check and command of both detectors' images.
struct DriveTest : MapDriverTest {
  Picture scores{record_spec<SnowScores>()}, order{record_spec<DriveOrder>()}, decision{record_spec<Decision>()},
      check{record_spec<CrossCheck>()}, command{record_spec<DriveCommand>()};
  Decide decide{config};
  CompareWays compare{config};
  Drive drive{config};
  int64_t now = 0;

  DriveTest() {
    config.decide.hold = 0;
    order.image().set_blind(Reason::no_drive);
    make_record<DriveOrder>(order.image());
    decide.check(std::vector{grid.spec(), reason.spec(), scores.spec()});
    compare.check(std::vector{grid.spec(), reason.spec(), scores.spec()});
    drive.check(std::vector{decision.spec(), order.spec(), check.spec()});
    say(1, 1);
  }
  void say(double free, double left) {
    SnowScores& s = make_record<SnowScores>(scores.image());
    s.free_difference = free;
    s.left_difference = left;
    s.clear = 0.4;
  }
  const DriveCommand& step(bool sees = true) {
    now += 100 * ms;
    for (Picture* picture : {&grid, &reason, &scores, &decision, &check, &command}) picture->image().timestamp_ns = now;
    const Image* const in[] = {&grid.image(), &reason.image(), &scores.image()};
    for (Picture* picture : {&decision, &check, &command}) picture->image().state = ImageState::valid;
    Image *const decided[] = {&decision.image()}, *const checked[] = {&check.image()}, *const driven[] = {&command.image()};
    if (sees) {
      if (decide.process(in, decided) == Outcome::invalid) decision.image().set_blind(decision.image().reason);
      if (grid.image().valid()) {
        EXPECT_TRUE(decision.image().valid());
        EXPECT_EQ(compare.process(in, checked), Outcome::valid);
      } else {
        check.image().set_blind(grid.image().reason);
      }
    } else {
      decision.image().set_blind(Reason::too_dark);
      check.image().set_blind(Reason::too_dark);
    }
    const Image* const orders[] = {&decision.image(), &order.image(), &check.image()};
    if (drive.process(orders, driven) == Outcome::invalid) command.image().set_blind(command.image().reason);
    return *command.image().row<DriveCommand>(0);
  }
  const Decision& decided() { return *record_of<Decision>(decision.image()); }
  const CrossCheck& checked() { return *record_of<CrossCheck>(check.image()); }
};

TEST_F(DriveTest, fast_where_nothing_is_near_and_slow_where_something_is) {
  EXPECT_DOUBLE_EQ(step().speed, config.decide.speed);
  obstacle(2.05, 0);
  const double part = 1.05 / 2;
  EXPECT_NEAR(step().speed, config.decide.leastSpeed + part * (config.decide.speed - config.decide.leastSpeed), 1e-6);
  say(0.25 * 0.4, 1);
  EXPECT_NEAR(step().speed, config.decide.leastSpeed + 0.25 * (config.decide.speed - config.decide.leastSpeed), 1e-6)
      << "the less clear of both";
  EXPECT_EQ(step().turn_rate, 0);
}

TEST_F(DriveTest, an_obstacle_that_one_detector_sees_is_one_and_that_one_says_where_to_evade) {
  say(-0.1, -1);
  EXPECT_LT(step().turn_rate, 0);
  EXPECT_EQ(command.image().row<DriveCommand>(0)->speed, 0);
  EXPECT_EQ(decided().steering, Steering::turn_right);
  EXPECT_EQ(decided().decider, Decider::snow);
  say(1, -1);
  step();
  EXPECT_EQ(decided().steering, Steering::forward);
  EXPECT_EQ(decided().decider, Decider::vdisparity);
  for (double left = 0; left > -1; left -= 0.1) obstacle(0.95, left - 0.05);
  EXPECT_GT(step().turn_rate, 0);
  EXPECT_EQ(decided().decider, Decider::vdisparity) << "the classifier would turn right";
}

TEST_F(DriveTest, what_one_frame_alone_is_sure_of_near_the_rover_costs_a_frame_of_turning) {
  config.decide.hold = 2;
  step();
  put(0.95, 0, -1, CellReason::obstacle);  // as the map that remembers tells it on ground that was free
  EXPECT_EQ(step().speed, 0);
  EXPECT_EQ(decided().steering, Steering::turn_left);
  put(0.95, 0, 0, CellReason::floor);
  EXPECT_DOUBLE_EQ(step().speed, config.decide.leastSpeed) << "slowly: the classifiers saw nothing";
  EXPECT_EQ(decided().steering, Steering::forward);
}

TEST_F(DriveTest, sensitivity_moves_the_border_of_both_classifiers) {
  say(-0.1, -0.1);
  SnowScores& s = *scores.image().row<SnowScores>(0);
  s.obstacle_sensitivity = 0.2;
  step();
  EXPECT_EQ(decided().steering, Steering::forward);
  s.obstacle_sensitivity = 0;
  s.direction_sensitivity = 0.2;
  step();
  EXPECT_EQ(decided().steering, Steering::turn_left);
}

TEST_F(DriveTest, agreement_is_counted_and_disagreement_slows_until_half_a_second_after) {
  EXPECT_EQ(step().slowed, 0u);
  say(-1, 1);
  const DriveCommand& turning = step();
  EXPECT_EQ(turning.slowed, 1u);
  EXPECT_DOUBLE_EQ(turning.turn_rate, config.decide.turnRate / 2);
  step();
  EXPECT_EQ(checked().agree, 0u);
  EXPECT_EQ(checked().map_free, 1u);
  EXPECT_EQ(checked().snow_free, 0u);
  EXPECT_NEAR(checked().disagreeing_s, 0.1, 1e-9);
  say(1, 1);
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(step().speed, config.decide.leastSpeed) << i;
  EXPECT_EQ(step().slowed, 0u);
  EXPECT_DOUBLE_EQ(step().speed, config.decide.speed);
  obstacle(0.95, 0);
  step();
  say(-1, 1);
  step();
  EXPECT_EQ(checked().agree, 1u) << "both see it";
  EXPECT_EQ(checked().disagreeing_s, 0);
  EXPECT_EQ(checked().only_map_free, 2u);
  EXPECT_EQ(checked().only_snow_free, 1u);
  EXPECT_EQ(checked().agreed, 8u);
  EXPECT_NEAR(checked().corridor_m, 0.95, 1e-6);
}

TEST_F(DriveTest, before_a_map_that_is_blind_the_classifiers_turn_it_and_never_send_it_ahead) {
  grid.image().set_blind(Reason::no_floor);
  say(1, 1);
  EXPECT_EQ(step().speed, 0);
  EXPECT_EQ(command.image().reason, Reason::no_floor);
  EXPECT_FALSE(command.image().valid()) << "the way that one of them calls free is not driven";
  say(-1, 1);
  const DriveCommand& told = step();
  EXPECT_TRUE(command.image().valid());
  EXPECT_EQ(decided().decider, Decider::snow);
  EXPECT_EQ(told.speed, 0);
  EXPECT_DOUBLE_EQ(told.turn_rate, config.decide.turnRate / 2) << "slowly, as nobody agrees";
  EXPECT_EQ(told.slowed, 1u);
  say(1, 1);
  step();
  EXPECT_FALSE(command.image().valid());
  grid.image().state = ImageState::valid;
  EXPECT_DOUBLE_EQ(step().speed, config.decide.leastSpeed) << "half a second longer";
}

TEST_F(DriveTest, the_operator_wins_while_the_order_is_young_also_where_nobody_sees) {
  order.image().state = ImageState::valid;
  DriveOrder& said = *order.image().row<DriveOrder>(0);
  said.speed = -0.3;
  said.turn_rate = 0.7;
  said.age_s = 0.299;
  said.timestamp_ns = 7000 * ms;
  for (const bool sees : {true, false}) {
    const DriveCommand& told = step(sees);
    EXPECT_TRUE(command.image().valid());
    EXPECT_EQ(told.speed, -0.3);
    EXPECT_EQ(told.turn_rate, 0.7);
    EXPECT_EQ(told.decider, Decider::operator_order);
    EXPECT_EQ(told.valid_until_ns, 7300 * ms) << "not for a frame longer";
  }
  order.image().flags = flag_synthetic | flag_replayed;
  EXPECT_EQ(step().valid_until_ns, 0) << "what is replayed has its time of another clock";
  order.image().flags = 0;
  said.age_s = 0.301;
  EXPECT_EQ(step().decider, Decider::vdisparity);
  EXPECT_EQ(command.image().row<DriveCommand>(0)->valid_until_ns, 0);
  EXPECT_DOUBLE_EQ(command.image().row<DriveCommand>(0)->speed, config.decide.speed);
  step(false);
  EXPECT_FALSE(command.image().valid());
  EXPECT_EQ(command.image().reason, Reason::too_dark);
}

TEST_F(DriveTest, takes_nothing_from_the_heap) {
  obstacle(0.95, 0);
  step();
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 20; ++i) step(i % 3 > 0);
  EXPECT_EQ(allocations_of_this_thread(), before);
}

TEST(Decide, refuses_what_is_no_detector) {
  const Config config;
  const ImageSpec grid{Pixel::int8, 0, 5, 5}, reason{Pixel::gray8, 0, 5, 5}, other{Pixel::gray8, 0, 6, 5};
  for (const std::vector<ImageSpec>& wrong :
       {std::vector<ImageSpec>{}, {grid}, {grid, other}, {record_spec<Decision>()}, {grid, reason, reason}}) {
    Decide decide(config);
    EXPECT_THROW(decide.check(wrong), FormatError) << wrong.size();
  }
  CompareWays compare(config);
  EXPECT_THROW(compare.check(std::vector{grid, reason}), FormatError) << "one detector agrees with nobody";
}

}  // namespace
}  // namespace vdisp
