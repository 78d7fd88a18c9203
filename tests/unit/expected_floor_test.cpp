// expected_floor_test.cpp: which floor is expected of a frame, and where it lies; truth from points of a plane, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/expected_floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/stages/disparity.h"
#include "daemon/stages/projection.h"
#include "daemon/stages/provisional_floor.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int width = 320, height = 240;
constexpr double f = 400, baseline = 0.1, cx = 160, cy = 120, cx_offset = 3, up = 0.4, pitch = 0.1;

/// The disparity at which the pixel sees the plane `up` m below a camera with this pitch and roll: the ray's depth where it is that low.
double truth(double u, double v, double below = up, double roll = 0) {
  const Point ray = horizontal({(u - cx) / f, (v - cy) / f, 1}, pitch, roll);
  return f * baseline * ray.y / below + cx_offset;
}

struct ExpectedFloorTest : testing::Test {
  Config config;
  Picture view{Pixel::disparity16, width, height};
  FloorModel last{};

  ExpectedFloorTest() {
    view.image().camera = {static_cast<float>(f),
                           static_cast<float>(cx),
                           static_cast<float>(cy),
                           static_cast<float>(baseline),
                           static_cast<float>(cx_offset),
                           0,
                           48,
                           {}};
    const FloorLine line = floor_line(stereo_view(view.image()), up, pitch);
    last.state = FloorState::found;
    last.a = line.slope / 16;
    last.b = line.row0;
    last.pitch_rad = pitch;
    last.roll_rad = std::nan("");
    last.height_m = up;
  }
  void mount(double at_height) {
    config.mounting.height = static_cast<float>(at_height);
    config.mounting.pitch = static_cast<float>(pitch);
  }
  static void expect_near(const std::optional<ExpectedFloor>& floor, double below, double roll = 0, double error = 0.07) {
    ASSERT_TRUE(floor);
    for (int v = 100; v < height; v += 20)
      for (int u = 4; u < width; u += 24)
        EXPECT_NEAR(floor->row(v).at(u) / 16.0, truth(u, v, below, roll) - 1 / 32.0, error) << v << ' ' << u;
  }
};

TEST_F(ExpectedFloorTest, the_last_floor_is_expected_again) {
  FloorExpectation expectation(config);
  expect_near(expectation.expect(view.image(), &last), up);
}

TEST_F(ExpectedFloorTest, the_last_floor_goes_before_the_mounting_it_agrees_with) {
  mount(0.44);
  FloorExpectation expectation(config);
  expect_near(expectation.expect(view.image(), &last), up);
  expect_near(expectation.expect(view.image(), nullptr), 0.44);
}

TEST_F(ExpectedFloorTest, a_floor_that_the_mounting_contradicts_is_not_expected) {
  last.mounting_differs = 1;
  mount(0.8);
  FloorExpectation expectation(config);
  expect_near(expectation.expect(view.image(), &last), 0.8);
}

TEST_F(ExpectedFloorTest, a_ramp_is_expected_though_the_mounting_contradicts_it_and_what_is_too_steep_is_not) {
  mount(up);
  last.model = FloorKind::profile;
  last.mounting_differs = 1;
  const double before = config.mounting.pitch;
  config.mounting.pitch = static_cast<float>(pitch - 0.2);  // the ramp falls by 0.2 against where the rover stands
  FloorExpectation expectation(config);
  expect_near(expectation.expect(view.image(), &last), up);
  config.floor.maxSlope = 0.15f;
  config.mounting.pitch = static_cast<float>(before);
  last.pitch_rad = pitch + 0.2;
  expect_near(expectation.expect(view.image(), &last), up);  // the mounting's
  config.floor.maxSlope = 0.35f;
  last.pitch_rad = pitch;
  last.height_m = 1.4 * up;
  last.b += 5;
  expect_near(expectation.expect(view.image(), &last), up);  // a table beside it, say
}

// 15 degrees steep from 1.45 camera heights ahead on: its plane lies 1 - cos 15 + 1.45 sin 15 = 0.41 of the camera's height nearer to the
// camera where it falls, and 0.34 farther where it rises.
TEST_F(ExpectedFloorTest, a_ramp_is_expected_also_where_its_plane_is_led_on_far_to_the_rover) {
  const double slope = 0.2618, near = std::cos(slope) - 1.45 * std::sin(slope), far = std::cos(slope) + 1.45 * std::sin(slope);
  last.model = FloorKind::profile;
  last.mounting_differs = 1;
  const auto expects = [&](double steep, double height_over_ramp) {
    mount(up / height_over_ramp);
    config.mounting.pitch = static_cast<float>(pitch - steep);
    FloorExpectation expectation(config);
    const auto floor = expectation.expect(view.image(), &last);
    return floor && std::abs(floor->row(160).at(200) / 16.0 - truth(200, 160)) < 0.1;
  };
  EXPECT_TRUE(expects(-slope, near));
  EXPECT_TRUE(expects(slope, far));
  EXPECT_TRUE(expects(-0.2, 0.66));
  // So steep a ramp would have to begin farther off than the ground that is seen first; and what rises does not lie nearer.
  EXPECT_FALSE(expects(-0.2, near));
  EXPECT_FALSE(expects(slope, 0.62));
  EXPECT_FALSE(expects(-slope, 2 - near));
  EXPECT_FALSE(expects(-0.34, 0.54));  // a table, or a wall that leans
}

/// Ground that is level up to `foot` m ahead, then rises by `slope`, and from `top` on is level again: what the pixel's ray meets first.
double on_ramp(double v, double foot, double slope, double top) {
  const Point ray = horizontal({0, (v - cy) / f, 1}, pitch, 0);
  for (double ahead = 0.2; ahead < 60; ahead += 0.0005) {
    const double ground = up - slope * (std::clamp(ahead, foot, top) - foot);  // m below the camera
    if (ray.y * ahead / ray.z >= ground) return f * baseline / (ahead / ray.z) + cx_offset;
  }
  return cx_offset;
}

TEST_F(ExpectedFloorTest, the_floor_expected_bends_with_the_ground_and_goes_on_where_it_was_not_seen) {
  last.model = FloorKind::profile;
  last.profile_count = 50;
  last.profile_start_m = 0.05f;
  last.profile_step_m = 0.1f;
  const double foot = 1.55, slope = 0.15;
  for (double top : {2.55, 100.0}) {
    for (uint32_t i = 0; i < last.profile_count; ++i) {
      const double ahead = 0.05 + 0.1 * i;
      last.profile_m[i] = static_cast<float>(slope * (std::clamp(ahead, foot, top) - foot));
    }
    // What is told behind that is nothing but its end: the ramp may go on, and a top that was seen goes on level.
    last.profile_seen = top > 50 ? 25 : 40;
    for (uint32_t i = last.profile_seen; i < last.profile_count; ++i) last.profile_m[i] = last.profile_m[last.profile_seen - 1];
    FloorExpectation expectation(config);
    expectation.prepare(view.spec());
    const auto floor = expectation.expect(view.image(), &last);
    ASSERT_TRUE(floor);
    int rows = 0;
    for (int v = floor->first_row(width) + 4; v < height; ++v, ++rows)
      ASSERT_NEAR(floor->row(v).at(160) / 16.0, on_ramp(v, foot, slope, top), 0.12) << v << ' ' << top;
    EXPECT_GT(rows, 100);
  }
}

// The sanitizer sees what is written beside the rows.
TEST_F(ExpectedFloorTest, a_camera_that_sees_no_horizon_has_ground_in_every_row) {
  const double steep = 0.9;
  const FloorLine line = floor_line(stereo_view(view.image()), up, steep);
  last.a = line.slope / 16;
  last.b = line.row0;
  last.pitch_rad = steep;
  last.model = FloorKind::profile;
  last.profile_count = last.profile_seen = 50;
  last.profile_start_m = 0.05f;
  last.profile_step_m = 0.1f;
  FloorExpectation expectation(config);
  expectation.prepare(view.spec());
  const auto floor = expectation.expect(view.image(), &last);
  ASSERT_TRUE(floor);
  EXPECT_EQ(floor->first_row(width), 0);
  ASSERT_EQ(floor->bent.size(), static_cast<size_t>(height));
  for (int v = 0; v < height; ++v) EXPECT_NEAR(floor->at_row(v), (v - last.b) / (16 * last.a), 0.01) << v;
}

TEST_F(ExpectedFloorTest, behind_a_crest_rows_go_on_with_what_is_seen_there) {
  last.model = FloorKind::profile;
  last.profile_count = last.profile_seen = 50;
  last.profile_start_m = 0.05f;
  last.profile_step_m = 0.1f;
  for (uint32_t i = 0; i < last.profile_count; ++i) {  // falls by 0.3 m, from 1.5 to 2.0 m ahead: steeper than the line of sight
    last.profile_m[i] = static_cast<float>(-0.6 * (std::clamp(0.05 + 0.1 * i, 1.55, 2.05) - 1.55));
  }
  FloorExpectation expectation(config);
  expectation.prepare(view.spec());
  const auto floor = expectation.expect(view.image(), &last);
  ASSERT_TRUE(floor);
  int hidden = 0;
  for (int v = height - 2; v > floor->first_row(width); --v) {
    EXPECT_LE(floor->at_row(v), floor->at_row(v + 1) + 1e-6) << "farther from row to row";
    hidden += floor->at_row(v + 1) - floor->at_row(v) > 3;
  }
  EXPECT_EQ(hidden, 1) << "one jump, over what the crest hides";
}

TEST_F(ExpectedFloorTest, a_bent_floor_that_is_banked_begins_where_one_of_its_sides_does) {
  std::vector<float> bent(height);
  for (int v = 0; v < height; ++v) bent[static_cast<size_t>(v)] = static_cast<float>(0.25 * (v - 80.5));
  const ExpectedFloor level{0.25, 80.5, 0, cx, cx_offset}, banked{0.25, 80.5, 0.02, cx, cx_offset};
  for (ExpectedFloor floor : {level, banked}) {
    const int first = floor.first_row(width);
    floor.bent = bent;
    EXPECT_EQ(floor.first_row(width), first) << floor.tilt;
  }
}

TEST_F(ExpectedFloorTest, a_mounting_alone_is_doubted_once_and_again_after_30_frames) {
  mount(up);
  FloorExpectation expectation(config);
  std::vector<uint64_t> doubted;
  for (view.image().sequence = 5; view.image().sequence < 40; ++view.image().sequence) {
    expectation.expect(view.image(), nullptr);
    if (expectation.doubtful(view.image())) doubted.push_back(view.image().sequence);
  }
  EXPECT_EQ(doubted, (std::vector<uint64_t>{5, 35}));
  expectation.forget();
  expectation.expect(view.image(), &last);
  EXPECT_FALSE(expectation.doubtful(view.image()));
}

TEST_F(ExpectedFloorTest, nothing_is_expected_of_the_first_frame_without_a_mounting) {
  FloorExpectation expectation(config);
  EXPECT_FALSE(expectation.expect(view.image(), nullptr));
  last.state = FloorState::lost;
  EXPECT_FALSE(expectation.expect(view.image(), &last));
}

TEST_F(ExpectedFloorTest, without_calibration_a_mounting_says_nothing) {
  mount(up);
  view.image().camera.f = 0;
  FloorExpectation expectation(config);
  EXPECT_FALSE(expectation.expect(view.image(), nullptr));
}

TEST_F(ExpectedFloorTest, a_floor_that_was_lost_is_expected_for_30_frames) {
  FloorExpectation expectation(config);
  view.image().sequence = 7;
  ASSERT_TRUE(expectation.expect(view.image(), &last));
  view.image().sequence = 37;
  expect_near(expectation.expect(view.image(), nullptr), up);
  view.image().sequence = 38;
  EXPECT_FALSE(expectation.expect(view.image(), nullptr));
}

// 30 frames a second, a degree and a half more from each to the next.
TEST_F(ExpectedFloorTest, a_camera_that_pitches_is_expected_to_go_on) {
  FloorExpectation expectation(config);
  const auto expect_of = [&](int frame, double pitched, FloorState state = FloorState::found) {
    view.image().timestamp_ns = frame * int64_t{33'000'000};
    view.image().sequence = static_cast<uint64_t>(frame);
    const FloorLine line = floor_line(stereo_view(view.image()), up, pitched);
    last.a = line.slope / 16;
    last.b = line.row0;
    last.pitch_rad = pitched;
    last.state = state;
    return expectation.expect(view.image(), &last);
  };
  const auto off = [&](const std::optional<ExpectedFloor>& floor, double pitched) {
    const Point ray = horizontal({0, (200 - cy) / f, 1}, pitched, 0);
    return std::abs(floor->at_row(200) - f * baseline * ray.y / up);
  };
  EXPECT_LT(off(expect_of(1, 0.10), 0.10), 0.01) << "nothing is known of where it turns";
  EXPECT_LT(off(expect_of(2, 0.126), 0.152), 0.01);
  EXPECT_LT(off(expect_of(2, 0.126), 0.126), 0.01) << "a second look at the same frame is at the floor it was given";
  EXPECT_LT(off(expect_of(3, 0.152), 0.178), 0.01);
  EXPECT_LT(off(expect_of(5, 0.178), 0.230), 0.01) << "twice the time";
  EXPECT_LT(off(expect_of(6, 0.30), 0.30), 0.01) << "more than a camera turns in a frame: another floor";
  EXPECT_LT(off(expect_of(7, 0.31), 0.32), 0.01);
  EXPECT_LT(off(expect_of(8, 0.31, FloorState::held), 0.31), 0.01) << "a floor that is not seen says nothing of turning";
  EXPECT_LT(off(expect_of(9, 0.33), 0.33), 0.01);
  EXPECT_LT(off(expect_of(40, 0.34), 0.34), 0.01) << "a second later it may turn otherwise";
}

TEST_F(ExpectedFloorTest, roll_tilts_the_floor) {
  for (double roll : {0.06, -0.06}) {
    config.mounting.roll = static_cast<float>(roll);
    mount(up);
    FloorExpectation expectation(config);
    // 1/8 px for blocks of columns that share a disparity, and what cos(roll) takes.
    expect_near(expectation.expect(view.image(), nullptr), up, roll, 0.25);
    expect_near(expectation.expect(view.image(), &last), up, roll, 0.25);
  }
}

TEST_F(ExpectedFloorTest, the_first_row_is_where_some_of_the_floor_is_below_its_horizon) {
  for (double tilt : {0.0, 0.02, -0.03}) {
    const ExpectedFloor floor{0.25, 80.5, tilt, cx, cx_offset};
    for (int v = 0; v < height; ++v) {
      bool some = false;
      for (int u = 0; u < width; ++u) some = some || 0.25 * (v - 80.5) + tilt * (u - cx) >= 0;
      ASSERT_EQ(v >= floor.first_row(width), some) << tilt << ' ' << v;
    }
  }
}

TEST_F(ExpectedFloorTest, a_floor_that_begins_far_away_has_a_first_row_all_the_same) {
  EXPECT_EQ((ExpectedFloor{0.25, -1e12, 0, cx, 0}.first_row(width)), 0);
  EXPECT_GE((ExpectedFloor{0.25, 1e12, 0, cx, 0}.first_row(width)), height);
}

TEST_F(ExpectedFloorTest, a_first_look_shows_the_floor_of_raw_matches) {
  view.fill<int16_t>([](int v, int u) {
    const double d = truth(u, v);
    if (v < 110 || (u + v) % 7 == 0) return rejected(Rejected::not_unique);
    return static_cast<int16_t>(std::lround(16 * d));
  });
  Machine machine;
  ProvisionalFloor provisional(machine, config);
  provisional.prepare(view.spec());
  const FloorModel* found = provisional.find(view.image());
  ASSERT_NE(found, nullptr);
  FloorExpectation expectation(config);
  expect_near(expectation.expect(view.image(), found), up, 0, 0.5);
  view.fill<int16_t>([](int, int) { return rejected(Rejected::not_unique); });
  const FloorModel* none = provisional.find(view.image());
  EXPECT_TRUE(!none || none->state == FloorState::lost);
}

}  // namespace
}  // namespace vdisp
