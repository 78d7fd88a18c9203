// inputs_test.cpp: what of odometry, IMU, drive orders and events is believed, and what the tree is told of it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/inputs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/control/republish.h"
#include "daemon/core/driver.h"

namespace vdisp {
namespace {

constexpr int64_t ms = 1'000'000, start = 1'000'000 * ms;
constexpr double none = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

OdometryMessage odometry(int64_t time, double x, double y = 0, double yaw = 0) {
  return {{}, time, x, y, yaw, none, none, none, none, none, none, none};
}
ImuMessage imu(int64_t time, double x, double y, double z) { return {{}, time, {x, y, z}, {none, none, none}}; }
EventMessage event(int64_t time, const char* label) {
  EventMessage message{{}, time, {}};
  std::string_view(label).copy(message.label, sizeof message.label);
  return message;
}

struct InputsTest : testing::Test {
  Config config;
  Inputs inputs{config};
  BufferOutlet outlet{record_spec<Odometry>()};

  Refusal take(const OdometryMessage& message, int64_t now, uint64_t sender = 1) { return inputs.take(message, sender, now); }
  /// Ten samples a second, 1 m/s ahead from x; the time of the last.
  int64_t drive(double x, int count, int64_t begin) {
    for (int i = 0; i < count; ++i) {
      const int64_t time = begin + i * 100 * ms;
      EXPECT_EQ(take(odometry(time, x + 0.1 * i), time), Refusal::none);
    }
    return begin + (count - 1) * 100 * ms;
  }
  template <class Record, class Write>
  const Record& written(BufferOutlet& to, Write write, int64_t now) {
    Image& image = *Image::make(&to.loan(), record_spec<Record>());
    (inputs.*write)(image, now);
    return *record_of<Record>(image);
  }
  const Odometry& published(int64_t now) { return written<Odometry>(outlet, &Inputs::write_odometry, now); }
  const Image& image() { return outlet.loan(); }
};

TEST_F(InputsTest, nothing_ever_came_is_blind_with_the_reason) {
  const Odometry& record = published(start);
  EXPECT_FALSE(image().valid());
  EXPECT_EQ(image().reason, Reason::no_odometry);
  EXPECT_EQ(record.tally.accepted + record.tally.refused, 0u);
}

TEST_F(InputsTest, the_newest_is_published_with_its_own_time_and_its_age_until_maxAge) {
  const int64_t last = drive(0, 5, start);
  EXPECT_DOUBLE_EQ(published(last + 30 * ms).x, 0.4);
  EXPECT_TRUE(image().valid());
  EXPECT_EQ(image().timestamp_ns, last);
  EXPECT_EQ(published(last + 30 * ms).timestamp_ns, last);
  EXPECT_DOUBLE_EQ(published(last + 30 * ms).age_s, 0.03);
  published(last + 499 * ms);
  EXPECT_TRUE(image().valid());
  published(last + 501 * ms);
  EXPECT_EQ(image().reason, Reason::no_odometry);
  config.control.maxAge = 2;
  published(last + 501 * ms);
  EXPECT_TRUE(image().valid()) << "maxAge is live";
}

TEST_F(InputsTest, a_step_counts_what_came_since_the_step_before) {
  drive(0, 5, start);
  EXPECT_EQ(published(start).tally.in_step, 5u);
  EXPECT_EQ(published(start).tally.in_step, 0u);
  EXPECT_EQ(published(start).tally.accepted, 5u);
}

TEST_F(InputsTest, what_is_no_number_or_no_rovers_is_refused) {
  for (const double bad : {none, infinite, -infinite}) {
    EXPECT_EQ(take(odometry(start, bad), start), Refusal::not_finite);
    EXPECT_EQ(take(odometry(start, 0, bad), start), Refusal::not_finite);
    EXPECT_EQ(take(odometry(start, 0, 0, bad), start), Refusal::not_finite);
  }
  EXPECT_EQ(take(odometry(start, 1e8), start), Refusal::out_of_range);
  OdometryMessage message = odometry(start, 0);
  message.z = infinite;
  EXPECT_EQ(take(message, start), Refusal::out_of_range);
  message = odometry(start, 0);
  message.yaw_deviation = -1;
  EXPECT_EQ(take(message, start), Refusal::out_of_range);
  const InputTally& tally = published(start).tally;
  EXPECT_EQ(tally.accepted, 0u);
  EXPECT_EQ(tally.refused, 12u);
  EXPECT_EQ(tally.last_refusal, Refusal::out_of_range);
}

TEST_F(InputsTest, time_that_runs_backwards_or_is_not_this_machines_is_refused) {
  drive(0, 3, start);
  const int64_t now = start + 200 * ms;
  EXPECT_EQ(take(odometry(now, 0.2), now), Refusal::backwards) << "the same time again";
  EXPECT_EQ(take(odometry(now - ms, 0.2), now), Refusal::backwards);
  EXPECT_EQ(take(odometry(now + 100 * ms, 0.2), now), Refusal::ahead);
  EXPECT_EQ(take(odometry(now - 501 * ms, 0.2), now), Refusal::late);
  for (const int64_t extreme : {std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max(), int64_t{0}})
    EXPECT_NE(take(odometry(extreme, 0.2), now), Refusal::none);
  EXPECT_EQ(take(odometry(now + ms, 0.2), now + ms), Refusal::none) << "and the next good one is taken";
}

TEST_F(InputsTest, a_single_jump_is_refused_and_changes_nothing) {
  const int64_t last = drive(0, 5, start);
  EXPECT_EQ(take(odometry(last + 100 * ms, 3), last + 100 * ms), Refusal::jump) << "26 m/s";
  EXPECT_EQ(take(odometry(last + 150 * ms, 0.45, 0, 2), last + 150 * ms), Refusal::jump) << "13 rad/s";
  EXPECT_EQ(take(odometry(last + 200 * ms, 0.6), last + 200 * ms), Refusal::none);
  EXPECT_EQ(published(last + 200 * ms).frame, 0u);
  config.control.maxSpeed = 50;
  EXPECT_EQ(take(odometry(last + 300 * ms, 3), last + 300 * ms), Refusal::none) << "maxSpeed is live";
}

TEST_F(InputsTest, turning_past_half_a_turn_is_no_jump) {
  EXPECT_EQ(take(odometry(start, 0, 0, M_PI - 0.01), start), Refusal::none);
  EXPECT_EQ(take(odometry(start + 100 * ms, 0, 0, -M_PI + 0.01), start + 100 * ms), Refusal::none);
}

TEST_F(InputsTest, odometry_that_goes_on_steadily_elsewhere_is_a_new_frame_after_half_a_second) {
  const int64_t last = drive(10, 5, start);
  int64_t first_taken = 0;
  for (int64_t time = last + 100 * ms; !first_taken && time < last + 3000 * ms; time += 100 * ms) {
    if (take(odometry(time, 1e-9 * static_cast<double>(time - last)), time) == Refusal::none) first_taken = time;
  }
  EXPECT_EQ(first_taken, last + 600 * ms);
  EXPECT_EQ(published(first_taken).frame, 1u);
  EXPECT_EQ(published(first_taken).tally.refused, 5u);
  EXPECT_EQ(take(odometry(first_taken + 100 * ms, 0.7), first_taken + 100 * ms), Refusal::none);
}

TEST_F(InputsTest, odometry_that_jumps_about_is_never_believed) {
  const int64_t last = drive(0, 5, start);
  for (int i = 1; i < 100; ++i) EXPECT_EQ(take(odometry(last + i * 50 * ms, i % 2 ? 1000 : -1000), last + i * 50 * ms), Refusal::jump) << i;
}

TEST_F(InputsTest, a_second_sender_is_refused_until_the_first_is_silent_or_gone) {
  drive(0, 3, start);
  const int64_t now = start + 210 * ms;
  EXPECT_EQ(take(odometry(now, 0.2), now, 2), Refusal::other_sender);
  EXPECT_EQ(take(odometry(start + 300 * ms, 0.3), start + 300 * ms, 1), Refusal::none);
  inputs.forget(1);
  EXPECT_EQ(take(odometry(start + 400 * ms, 0.4), start + 400 * ms, 2), Refusal::none);
  EXPECT_EQ(take(odometry(start + 1000 * ms, 0.5), start + 1000 * ms, 3), Refusal::none) << "600 ms of silence";
}

TEST_F(InputsTest, gravity_tells_pitch_and_roll_in_the_projects_signs) {
  BufferOutlet to(record_spec<Imu>());
  const double g = 9.81, t = 0.2;
  int64_t time = start;
  const auto told = [&](double x, double y, double z) -> const Imu& {
    time += 10 * ms;
    EXPECT_EQ(inputs.take(imu(time, x, y, z), 1, time), Refusal::none);
    return written<Imu>(to, &Inputs::write_imu, time);
  };
  EXPECT_NEAR(told(0, 0, g).pitch, 0, 1e-12);
  EXPECT_NEAR(told(-g * std::sin(t), 0, g * std::cos(t)).pitch, t, 1e-12) << "nose down: up has a part to the back";
  EXPECT_NEAR(told(0, g * std::sin(t), g * std::cos(t)).roll, t, 1e-12) << "right side low: up has a part to the left";
  EXPECT_EQ(inputs.take(imu(time + 10 * ms, 0, 0, 1), 1, time + 10 * ms), Refusal::out_of_range) << "falling";
  EXPECT_EQ(inputs.take(imu(time + 10 * ms, 0, 0, 30), 1, time + 10 * ms), Refusal::out_of_range) << "hit";
  EXPECT_EQ(inputs.take(imu(time + 10 * ms, 0, none, 9.81), 1, time + 10 * ms), Refusal::not_finite);
  written<Imu>(to, &Inputs::write_imu, time + 1000 * ms);
  EXPECT_EQ(to.loan().reason, Reason::no_imu);
}

TEST_F(InputsTest, events_are_kept_newest_first_and_must_be_printable) {
  BufferOutlet to(record_spec<Events>());
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(inputs.take(event(start + i, ("event " + std::to_string(i)).c_str()), 1 + i % 2, start), Refusal::none);
  EXPECT_EQ(inputs.take(event(start, ""), 1, start), Refusal::out_of_range);
  EXPECT_EQ(inputs.take(event(start, "line\nbreak"), 1, start), Refusal::out_of_range);
  EventMessage endless = event(start, "x");
  std::fill(std::begin(endless.label), std::end(endless.label), 'x');
  EXPECT_EQ(inputs.take(endless, 1, start), Refusal::out_of_range);
  const Events& events = written<Events>(to, &Inputs::write_events, start + ms);
  EXPECT_EQ(events.count, Events::capacity);
  EXPECT_EQ(events.tally.in_step, 10u);
  EXPECT_STREQ(events.entries[0].label, "event 9");
  EXPECT_STREQ(events.entries[7].label, "event 2");
}

TEST_F(InputsTest, what_the_source_tells_goes_before_the_socket_and_is_of_the_frame) {
  Odometry known{};
  known.x = 7;
  known.timestamp_ns = 123;
  Imu felt{};
  felt.pitch = 0.1;
  Driver driver(1);
  const auto handles = driver.add_set({std::begin(input_topics), std::end(input_topics)},
                                      std::make_unique<Republish>(
                                          inputs, [&] { return &known; }, [&] { return &felt; }),
                                      {}, Need::always);
  EXPECT_EQ(take(odometry(start, 0), start), Refusal::recorded);
  EXPECT_EQ(inputs.take(imu(start, 0, 0, 9.81), 1, start), Refusal::recorded);
  std::vector<std::pair<ImageState, double>> seen;
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  driver.set_config_generation(5);
  driver.set_viewer([&](const Topic& topic, const Image& image) {
    EXPECT_EQ(image.config_generation, 5u);
    if (topic.name == "in/imu") {
      EXPECT_TRUE(image.valid() && record_of<Imu>(image)->pitch == 0.1);
    }
    if (topic.name != "in/odometry") return;
    EXPECT_TRUE(image.flags & flag_synthetic);
    EXPECT_EQ(image.timestamp_ns, 123);
    EXPECT_EQ(record_of<Odometry>(image)->age_s, 0);
    seen.emplace_back(image.state, record_of<Odometry>(image)->x);
  });
  EXPECT_EQ(driver.step(), Outcome::valid) << "blind inputs do not make the step blind";
  known.x = none;
  EXPECT_EQ(driver.step(), Outcome::valid);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0], std::pair(ImageState::valid, 7.0));
  EXPECT_EQ(seen[1].first, ImageState::blind);
}

TEST_F(InputsTest, what_was_recorded_is_shown_as_it_was_and_nothing_else_is_taken) {
  RecordedStep step;
  step.odometry = {Reason::none, flag_synthetic | flag_replayed, 123, {}};
  step.odometry.record.header = {Odometry::type, Odometry::version, sizeof(Odometry)};
  step.odometry.record.age_s = 0.25;
  step.odometry.record.tally.refused = 9;
  step.imu.reason = Reason::no_imu;
  step.imu.record.roll = 0.5;
  Driver driver(1);
  driver.add_set({std::begin(input_topics), std::end(input_topics)},
                 std::make_unique<Republish>(
                     inputs, [] { return nullptr; }, [] { return nullptr; }, [&] { return &step; }),
                 {}, Need::always);
  EXPECT_EQ(take(odometry(start, 0), start), Refusal::recorded);
  EXPECT_EQ(inputs.take(DriveMessage{{}, start, 1, 0}, 1, start), Refusal::recorded);
  EXPECT_EQ(inputs.take(event(start, "recording"), 1, start), Refusal::recorded);
  EXPECT_FALSE(inputs.recording_begins());
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  int seen = 0;
  driver.set_viewer([&](const Topic& topic, const Image& image) {
    if (const Odometry* record = record_of<Odometry>(image)) {
      EXPECT_TRUE(image.valid());
      EXPECT_EQ(image.timestamp_ns, 123);
      EXPECT_EQ(image.flags, flag_synthetic | flag_replayed);
      EXPECT_EQ(record->age_s, 0.25);
      EXPECT_EQ(record->tally.refused, 9u);
      ++seen;
    }
    if (topic.name == "in/imu") {
      EXPECT_EQ(image.reason, Reason::no_imu);
      EXPECT_EQ(image.row<Imu>(0)->roll, 0.5);
      ++seen;
    }
  });
  driver.step();
  EXPECT_EQ(seen, 2);
}

TEST_F(InputsTest, an_event_called_recording_is_told_once) {
  EXPECT_EQ(inputs.take(event(start, "recordings"), 1, start), Refusal::none);
  EXPECT_FALSE(inputs.recording_begins());
  EXPECT_EQ(inputs.take(event(start, "recording"), 1, start), Refusal::none);
  EXPECT_TRUE(inputs.recording_begins());
  EXPECT_FALSE(inputs.recording_begins());
}

}  // namespace
}  // namespace vdisp
