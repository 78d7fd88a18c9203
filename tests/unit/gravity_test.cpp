// gravity_test.cpp: a floor out of sight, held by an IMU; truth from the way the rover nods.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/gravity.h"

#include "tests/support/plane_scene.h"

namespace vdisp {
namespace {

/// A rover with an IMU that nods on level ground, 30 frames a second.
struct ImuTest : PlaneScene {
  int frame = 0;

  /// `felt`: pitch of the rover by the accelerometer; `lean`: its roll.
  void feel(double felt, double lean = 0, double force = 9.81) {
    const double up[3] = {-std::sin(felt), std::cos(felt) * std::sin(lean), std::cos(felt) * std::cos(lean)};
    sample({force * up[0], force * up[1], force * up[2]});
  }
  void sample(const std::array<double, 3>& acceleration, double age = 0) {
    Imu& record = make_record<Imu>(imu.image());
    std::copy_n(acceleration.begin(), 3, record.acceleration);
    std::fill_n(record.rate, 3, std::nan(""));
    record.age_s = age;
    record.timestamp_ns = time_ns();
    imu.image().state = ImageState::valid;
    imu.image().reason = Reason::none;
  }
  int64_t time_ns() const { return frame * int64_t{33'000'000}; }
  static double nod(int at) { return 0.087 * std::sin(2 * M_PI * 2 * at * 0.033); }
  /// The floor as it is where the rover nods by this.
  Outcome look(double nodding) {
    see(ground(high, 0, pitch + nodding));
    return find(33 * frame++);
  }
  /// Something flat before the lens.
  Outcome look_away() {
    see([](const Point&) { return 0.6; });
    return find(33 * frame++);
  }
  void SetUp() override {
    PlaneScene::SetUp();
    config.mounting.height = 0.8f;
    config.mounting.pitch = static_cast<float>(pitch);
  }
};

TEST_F(ImuTest, a_floor_out_of_sight_is_held_where_the_camera_turned_to) {
  for (bool told : {true, false}) {
    stage.reset();
    frame = 0;
    for (int i = 0; i < 3; ++i) {
      told ? feel(0) : imu.image().set_blind(Reason::no_imu);
      ASSERT_EQ(look(0), Outcome::valid);
    }
    for (int i = 1; i <= 6; ++i) {
      if (told) feel(0.02 * i);
      ASSERT_EQ(look_away(), Outcome::valid);
    }
    EXPECT_EQ(model().state, FloorState::held);
    EXPECT_NEAR(model().pitch_rad, told ? pitch + 0.12 : pitch, 0.005);
    EXPECT_NEAR(model().height_m, high, 0.01);
    EXPECT_EQ(model().imu, told ? ImuUse::used : ImuUse::none);
  }
}

TEST_F(ImuTest, with_a_camera_that_looks_aside_a_nod_of_the_rover_is_a_roll_of_the_camera) {
  config.mounting.yaw = static_cast<float>(M_PI / 2);  // to the left
  config.mounting.pitch = 0;
  config.limit.angRot = config.map.angRot = 0;
  for (int i = 0; i < 3; ++i) {
    feel(0);
    see(ground(high, 0, 0));
    ASSERT_EQ(find(33 * frame++), Outcome::valid);
  }
  feel(0.06);
  ASSERT_EQ(look_away(), Outcome::valid);
  EXPECT_NEAR(model().roll_rad, 0.06, 0.005) << "the rover's nose is at the camera's right side";
  EXPECT_NEAR(model().pitch_rad, 0, 0.005);
}

TEST_F(ImuTest, on_a_slope_gravity_is_not_the_floor_and_the_difference_is_told) {
  for (int i = 0; i < 200; ++i) {
    feel(-0.15);  // nose up, on ground that rises
    ASSERT_EQ(look(0), Outcome::valid);
  }
  EXPECT_NEAR(model().pitch_rad, pitch, 0.005) << "the floor is where the images show it";
  EXPECT_EQ(model().imu, ImuUse::used);
  EXPECT_EQ(model().gravity_differs, 1u);
  EXPECT_NEAR(model().gravity_pitch_rad, pitch - 0.15, 0.005);
  EXPECT_NEAR(model().steady_pitch_rad, pitch, 0.005);
  EXPECT_EQ(model().mounting_differs, 0u);
}

TEST_F(ImuTest, one_that_turns_the_other_way_is_ignored_until_it_agrees) {
  for (int i = 0; i < 60; ++i) {
    feel(-nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
    EXPECT_NEAR(model().pitch_rad, pitch + nod(i), 0.01) << "what the images show goes before, frame " << i;
  }
  EXPECT_EQ(model().imu, ImuUse::contradicts);
  for (int i = 60; i < 240; ++i) {
    feel(nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
  }
  EXPECT_EQ(model().imu, ImuUse::used);
}

TEST_F(ImuTest, one_that_nods_with_the_rover_is_used) {
  for (int i = 0; i < 60; ++i) {
    feel(nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
    if (i > 0) {
      EXPECT_EQ(model().imu, ImuUse::used) << i;
    }
  }
}

TEST_F(ImuTest, what_is_late_or_upside_down_or_jumps_or_is_no_gravity_is_not_used_and_says_why) {
  const auto use = [&] {
    EXPECT_EQ(look(0), Outcome::valid);
    EXPECT_NEAR(model().pitch_rad, pitch, 0.005);
    return model().imu;
  };
  const auto settle = [&] {
    for (int i = 0; i < 20; ++i) {
      feel(0);
      use();
    }
    EXPECT_EQ(model().imu, ImuUse::used);
  };
  settle();
  sample({0, 0, 9.81}, 0.2);
  EXPECT_EQ(use(), ImuUse::late);
  settle();
  feel(0, M_PI);
  EXPECT_EQ(use(), ImuUse::askew) << "upside down";
  sample({0, 9.81, 0});
  EXPECT_EQ(use(), ImuUse::askew) << "other axes";
  settle();
  feel(0.5);
  EXPECT_EQ(use(), ImuUse::jumped);
  settle();
  feel(0, 0, 12);
  EXPECT_EQ(use(), ImuUse::accelerating);
  sample({0, 0, 0});
  EXPECT_EQ(use(), ImuUse::accelerating);
  settle();
  --frame;
  feel(0);
  ++frame;
  EXPECT_EQ(use(), ImuUse::used) << "the same sample again: nothing turned";
  frame += 1000;
  feel(0.1);
  EXPECT_EQ(use(), ImuUse::settling) << "after a pause it begins anew";
}

TEST_F(ImuTest, a_jump_that_lasts_is_where_it_begins_anew) {
  for (int i = 0; i < 5; ++i) {
    feel(0);
    look(0);
  }
  int ignored = 0;
  for (int i = 0; i < 40; ++i) {
    feel(0.5);
    look(0);
    ignored += model().imu == ImuUse::jumped;
  }
  EXPECT_GT(ignored, 10);
  EXPECT_EQ(model().imu, ImuUse::used);
}

TEST_F(ImuTest, rates_of_turn_carry_over_what_braking_does_to_the_accelerometer) {
  const auto turning = [&](double felt, double rate) {
    feel(felt);
    Imu& record = *imu.image().row<Imu>(0);
    record.rate[0] = record.rate[2] = 0;
    record.rate[1] = rate;  // about y, to the left: nose down is positive
  };
  const auto frames = [&](int count, bool seen, const std::function<void(int)>& tell) {
    for (int i = 0; i < count; ++i) {
      tell(i);
      ASSERT_EQ(seen ? look(0) : look_away(), Outcome::valid);
    }
  };
  frames(3, true, [&](int) { turning(0, 0); });
  frames(6, false, [&](int) { turning(0.1, 0); });  // 1 m/s^2
  EXPECT_NEAR(model().pitch_rad, pitch, 0.025) << "nothing turned";
  stage.reset();
  frames(3, true, [&](int i) { turning(0, i == 2 ? 0.6 : 0); });
  frames(6, false, [&](int i) { turning(0.0198 * (i + 1), 0.6); });
  EXPECT_NEAR(model().pitch_rad, pitch + 0.119, 0.01);
}

}  // namespace
}  // namespace vdisp
