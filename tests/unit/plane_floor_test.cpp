// plane_floor_test.cpp: the floor as a plane and a profile; truth from points of planes, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/plane_floor.h"

#include <algorithm>
#include <vector>

#include "tests/support/plane_scene.h"

namespace vdisp {
namespace {

using PlaneFloorTest = PlaneScene;

TEST_F(PlaneFloorTest, measures_pitch_roll_and_height_of_banked_ground) {
  for (double roll : {-0.17, 0.0, 0.17}) {
    stage.reset();
    see(ground(high, roll));
    ASSERT_EQ(find(), Outcome::valid) << roll;
    EXPECT_NEAR(model().pitch_rad, pitch, 0.003) << roll;
    EXPECT_NEAR(model().roll_rad, roll, 0.003);
    EXPECT_NEAR(model().height_m, high, 0.005);
    EXPECT_EQ(model().state, FloorState::found);
  }
}

// Each frame draws its own planes. Uneven ground with a lawn at its right side: no plane lies on all of it.
TEST_F(PlaneFloorTest, what_is_found_does_not_depend_on_what_was_drawn) {
  config.mounting.height = 0.8f;
  see([](const Point& ray) {
    const double z = ground(high)(ray), x = ray.x * z;
    return z == 0 ? z : ground(high - 0.06 * std::sin(5 * z) * std::cos(4 * x) - (x > 0.2 ? 0.15 : 0))(ray);
  });
  std::vector<double> pitches, heights;
  for (uint64_t frame = 0; frame < 24; ++frame) {
    stage.reset();
    disparity.image().sequence = frame;
    ASSERT_EQ(find(), Outcome::valid) << frame;
    pitches.push_back(model().pitch_rad);
    heights.push_back(model().height_m);
  }
  const auto range = [](const std::vector<double>& values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return *most - *least;
  };
  EXPECT_LT(range(pitches), 0.0005);
  EXPECT_LT(range(heights), 0.0005);
}

TEST_F(PlaneFloorTest, a_wall_that_fills_most_of_the_view_is_not_the_floor) {
  config.mounting.height = 0.8f;
  see(with_wall(ground(high), 1.5, 2));
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().pitch_rad, pitch, 0.02);
  EXPECT_NEAR(model().height_m, high, 0.02);
}

TEST_F(PlaneFloorTest, the_ground_at_the_feet_is_the_floor_however_much_lies_lower) {
  config.mounting.height = 0.8f;
  const Scene low = ground(1.4), near = ground(high);
  see([&](const Point& ray) {
    const double z = near(ray);
    return z > 0 && horizontal({ray.x * z, ray.y * z, z}, pitch).z < 1.4 ? z : low(ray);
  });
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.06) << "of 0.36 m of it";
  map();
  EXPECT_EQ(why(1.25, 0), CellReason::floor);
  bool edge = false;
  for (double ahead = 1.35; ahead < 1.75; ahead += 0.1) edge = edge || (why(ahead, 0) == CellReason::drop_off && risk(ahead, 0) == 100);
  EXPECT_TRUE(edge) << "0.6 m down from 1.4 m on";
  for (double ahead = 1.75; ahead < 4; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead << " m: the bottom is no floor of this rover";
}

TEST_F(PlaneFloorTest, the_profile_follows_a_ramp) {
  constexpr double foot = 2, rise = 0.2;
  const Scene flat = ground(high);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double on_ramp = (high + rise * foot) / (h.y + rise * h.z), z = flat(ray);
    return on_ramp > 0 && on_ramp * h.z > foot && (z == 0 || on_ramp < z) ? on_ramp : z;
  });
  ASSERT_EQ(find(), Outcome::valid);
  const LocalFloor local(model(), view);
  const auto rises = [&](double from, double to) {
    return local.elevation(to) - local.elevation(from) + (to - from) * std::tan(model().pitch_rad - pitch);
  };
  EXPECT_NEAR(rises(2.5, 4), 0.3, 0.06);
  map();
  for (double ahead = 1.2; ahead < 4; ahead += 0.1) EXPECT_LT(risk(ahead, 0), 65) << ahead;
}

// What the ground at the feet leans by fills most of the picture: a plane that leans with it would be 0.15 m off 2 m aside.
TEST_F(PlaneFloorTest, a_bump_at_the_feet_does_not_bank_the_ground_ahead) {
  for (const double lean : {-0.07, 0.07}) {
    const Scene bump = ground(high, lean), flat = ground(high);
    see([&](const Point& ray) {
      const double z = bump(ray);
      return z > 0 && horizontal(ray, pitch).z * z < 2.5 ? z : flat(ray);
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    EXPECT_NEAR(model().roll_rad, 0, 0.02) << lean;
    map();
    for (int row = 0; row < 50; ++row) {
      for (int column = 0; column < 51; ++column) EXPECT_LT(ground_map[0]->at<int8_t>(row, column), 65) << row << ", " << column;
    }
  }
}

// Grazing ground is hardly matched: here in a strip of which one pixel a row is looked at.
TEST_F(PlaneFloorTest, the_profile_falls_where_little_of_the_falling_ground_is_seen) {
  constexpr double edge = 2, fall = 0.18;
  const Scene flat = ground(high);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray);
    if (z > 0 && h.z * z < edge) return z;
    const double slope = (high - fall * edge) / (h.y - fall * h.z);
    return slope > 0 && ray.x > 0 && ray.x < 5.5 / view.f ? slope : 0;
  });
  ASSERT_EQ(find(), Outcome::valid);
  const LocalFloor local(model(), view);
  for (double ahead = 2.5; ahead < 3.6; ahead += 0.25) EXPECT_NEAR(local.elevation(ahead), -fall * (ahead - edge), 0.05) << ahead;
}

// Where a kerb leads along the way, the matcher's windows hold both sides of it, and say some heights between.
TEST_F(PlaneFloorTest, the_profile_does_not_fall_by_the_few_points_between_higher_and_lower_ground) {
  constexpr double edge = 1.8, deep = 0.32, fall = 0.2;
  const Scene kerb = kerb_beside(edge, -0.4, deep);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double slope = (high - fall * edge) / (h.y - fall * h.z), on_it = h.z * slope - edge;
    return ray.x > 0 && ray.x < 5.5 / view.f && slope > 0 && on_it > 0 && on_it * fall < deep ? slope : kerb(ray);
  });
  ASSERT_EQ(find(), Outcome::valid);
  const LocalFloor local(model(), view);
  for (double ahead = 2; ahead < 4; ahead += 0.25) EXPECT_GT(local.elevation(ahead), -0.05) << ahead;
}

TEST_F(PlaneFloorTest, darkness_glare_and_blank_walls_are_blind_at_once_and_never_held) {
  see(ground(high));
  ASSERT_EQ(find(0), Outcome::valid);
  left.fill<uint8_t>([](int, int) { return uint8_t{3}; });
  EXPECT_EQ(find(10), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::too_dark);
  left.fill<uint8_t>([](int, int) { return uint8_t{255}; });
  EXPECT_EQ(find(20), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::too_bright);
  left.fill<uint8_t>([](int, int) { return uint8_t{100}; });
  disparity.fill<int16_t>([](int, int) { return rejected(Rejected::low_texture); });
  EXPECT_EQ(find(30), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_texture);
  disparity.fill<int16_t>([](int, int) { return rejected(Rejected::not_unique); });
  EXPECT_EQ(find(40), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_matches) << "texture, and nothing matches: blocked";
}

TEST_F(PlaneFloorTest, a_floor_out_of_sight_is_held_as_long_as_told) {
  config.floor.hold = 0.5;
  see(ground(high));
  ASSERT_EQ(find(0), Outcome::valid);
  see([](const Point&) { return 0.6; });  // something flat fills the view
  ASSERT_EQ(find(400), Outcome::valid);
  EXPECT_EQ(model().state, FloorState::held);
  EXPECT_EQ(model().reason, Reason::no_floor);
  EXPECT_NEAR(model().held_s, 0.4, 1e-6);
  EXPECT_TRUE(floor[1]->image().flags & flag_held);
  EXPECT_EQ(find(600), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_floor);
}

TEST_F(PlaneFloorTest, a_wrong_mounting_is_said_with_what_was_measured) {
  config.mounting.height = 1.6f;
  see(ground(high));
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.02);
  EXPECT_EQ(model().mounting_differs, 1u);
  config.mounting.height = 0.8f;
  stage.reset();
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_EQ(model().mounting_differs, 0u);
}

/// Half of what lies on the ground lies near enough a plane within the mounting's tolerances too: that plane must not be the floor.
TEST_F(PlaneFloorTest, a_wrong_mounting_does_not_bend_the_floor_towards_itself_whatever_was_drawn) {
  config.image_source.ndisp = 32;
  disparity.image().camera.disparities = 32;
  see(with_wall(with_wall(ground(high), 1.8, 0.35, -0.95, -0.4), 3.3, 0.55, -0.15, 1.4));
  for (const float told : {0.5f, 0.6f, 1.05f, 1.2f, 1.6f}) {
    config.mounting.height = told;
    config.mounting.pitch = static_cast<float>(pitch);
    for (uint64_t sequence = 0; sequence < 20; ++sequence) {
      stage.reset();
      disparity.image().sequence = sequence;
      ASSERT_EQ(find(), Outcome::valid) << told;
      EXPECT_NEAR(model().height_m, high, 0.02) << "told " << told << ", draws of frame " << sequence;
      EXPECT_NEAR(model().pitch_rad, pitch, 0.02) << "told " << told << ", draws of frame " << sequence;
    }
  }
}

/// Ten frames agree with [mounting]; then the rover turns to a wall, and comes so near that no floor is in view.
TEST_F(PlaneFloorTest, a_wall_that_fills_the_view_is_no_floor_where_the_mounting_is_known_to_be_right) {
  trust_mounting();
  const double steepest = config.floor.maxSlope + config.mounting.pitchTolerance;
  for (const double turned : {-0.9, -0.6, -0.3, 0.3, 0.6, 0.9})
    for (const double away : {0.7, 0.8, 0.9}) {
      see([&](const Point& ray) {
        const Point h = horizontal(ray, pitch);
        const double z = away / (h.z * std::cos(turned) + h.x * std::sin(turned)), below = ground(high)(ray);
        return z > 0 && (below == 0 || z < below) ? z : below;
      });
      for (int i = 0; i < 4; ++i) {
        ++disparity.image().sequence;
        if (find(ms += 400) != Outcome::valid) continue;
        EXPECT_LT(std::abs(model().pitch_rad - pitch), steepest) << "turned " << turned << ", " << away << " m away";
        EXPECT_LT(std::abs(model().roll_rad), steepest) << "turned " << turned << ", " << away << " m away";
        EXPECT_LT(std::abs(model().height_m - high), 0.35 * high) << "turned " << turned << ", " << away << " m away";
      }
      see(ground(high));
      ASSERT_EQ(find(ms += 400), Outcome::valid) << "back on the ground";
      EXPECT_NEAR(model().pitch_rad, pitch, 0.01);
    }
  see(with_wall(ground(high), 0.8, 3));
  ASSERT_EQ(find(ms += 600), Outcome::invalid) << "longer than hold";
  EXPECT_EQ(reason(), Reason::no_floor);
}

TEST_F(PlaneFloorTest, a_ramp_that_fills_the_view_is_a_floor_where_the_mounting_is_known_to_be_right) {
  for (const double rise : {0.17, 0.26, -0.17, -0.26}) {
    stage.reset();
    trust_mounting();
    // The ramp begins a metre ahead of the camera's foot, in all that is in view.
    const double below = (high + 1.0 * std::tan(rise)) * std::cos(rise);
    see(ground(below, 0, pitch + rise));
    ASSERT_EQ(find(ms += 100), Outcome::valid) << rise;
    EXPECT_EQ(model().state, FloorState::found) << rise;
    EXPECT_NEAR(model().pitch_rad, pitch + rise, 0.02);
    EXPECT_NEAR(model().height_m, below, 0.03);
  }
}

/// A camera that was knocked: nothing of what it sees can be its floor any more, until that lasted.
TEST_F(PlaneFloorTest, a_mounting_that_was_right_is_measured_anew_after_half_a_minute_without_a_floor) {
  trust_mounting();
  see(ground(1.3));
  for (int i = 0; i < 29; ++i) EXPECT_EQ(find(ms += 1000), Outcome::invalid) << i;
  for (int i = 0; i < 10; ++i) find(ms += 1000);
  EXPECT_EQ(model().state, FloorState::found);
  EXPECT_NEAR(model().height_m, 1.3, 0.03);
  EXPECT_EQ(model().mounting_differs, 1u);
}

TEST_F(PlaneFloorTest, a_mounting_of_another_roll_is_never_trusted) {
  config.mounting.roll = 0.5f;
  config.mounting.height = 0.8f;
  config.mounting.pitch = static_cast<float>(pitch);
  see(ground(high));
  for (int i = 0; i < 30; ++i) {
    ASSERT_EQ(find(ms += 100), Outcome::valid) << i;
    EXPECT_NEAR(model().roll_rad, 0, 0.03);
  }
}

TEST_F(PlaneFloorTest, a_mounting_changed_while_it_runs_is_not_trusted_before_it_is_seen_to_be_right) {
  trust_mounting();
  config.mounting.height = 1.6f;
  ASSERT_EQ(find(ms += 100), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.02);
  EXPECT_EQ(model().mounting_differs, 1u);
}

}  // namespace
}  // namespace vdisp
