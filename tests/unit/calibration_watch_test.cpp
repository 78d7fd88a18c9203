// calibration_watch_test.cpp: a calibration that holds is left alone, on simulated and real pairs; one that is off is said to have drifted,
// by how much and in which way. Truth: the simulator's own calibration, and what was done to it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/calibration_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "daemon/sources/source.h"
#include "daemon/stages/disparity.h"
#include "daemon/stages/rectify.h"
#include "ipc/outlet.h"

namespace vdisp {
namespace {

constexpr double degree = std::numbers::pi / 180;

struct Seen {
  CalibrationWatch last{};
  int drifted_at = -1;  ///< frame
};

/// Source, rectification, disparity and watch of a configuration, whose calibration was altered.
class Watch : public testing::Test {
 protected:
  Watch() {
    config_.image_source.source = "sim";
    config_.sim.rate = 0;
  }
  template <class Alter>
  Seen run(int frames, Alter alter) {
    Machine machine;
    Driver driver(1);
    auto source = open_source(config_);
    auto calibration = source->calibration();
    if (calibration) alter(*calibration);
    const auto camera = driver.add_set({"camera/left", "camera/right"}, std::move(source), {}, Need::always);
    const auto left = driver.add("left", std::make_unique<Rectify>(Side::left, calibration, machine, config_), {camera[0]});
    const auto right = driver.add("right", std::make_unique<Rectify>(Side::right, calibration, machine, config_), {camera[1]});
    const auto disparity = driver.add("disparity", std::make_unique<Disparity>(machine, config_), {left, right});
    driver.add("row_error", std::make_unique<CalibrationWatcher>(config_), {left, right, disparity}, Need::always);
    Seen seen;
    driver.set_viewer([&](const Topic& topic, const Image& image) {
      if (topic.name == "row_error" && image.valid()) seen.last = *record_of<CalibrationWatch>(image);
    });
    driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
    for (int i = 0; i < frames && driver.step() != Outcome::end; ++i)
      if (seen.last.state == CalibrationState::drifted && seen.drifted_at < 0) seen.drifted_at = i;
    return seen;
  }
  Seen run(int frames) {
    return run(frames, [](Calibration&) {});
  }
  /// As if the right camera's calibration said that it is turned by `angle` more about its view.
  static void turn(Calibration& calibration, double angle) {
    auto& r = (*calibration.raw)[1].rectification;
    const auto before = r;
    for (size_t i = 0; i < 3; ++i) {
      r[i] = std::cos(angle) * before[i] - std::sin(angle) * before[3 + i];
      r[3 + i] = std::sin(angle) * before[i] + std::cos(angle) * before[3 + i];
    }
  }
  Config config_;
};

TEST_F(Watch, a_calibration_that_holds_is_good_to_a_tenth_of_a_pixel) {
  const Seen seen = run(60);
  EXPECT_EQ(seen.last.state, CalibrationState::good);
  EXPECT_EQ(seen.last.drifts, 0u);
  EXPECT_LT(seen.last.median_px, 0.1);
  EXPECT_NEAR(seen.last.shift_px, 0, 0.05);
  EXPECT_NEAR(seen.last.rotation_rad, 0, 0.02 * degree);
  EXPECT_GT(seen.last.points, 300u);
}

TEST_F(Watch, shifts_of_one_and_two_pixels_are_said_within_a_second_and_told_from_a_rotation) {
  for (double rows : {1.0, -1.0, 2.0}) {
    const Seen seen = run(40, [&](Calibration& c) { (*c.raw)[1].projection[6] += rows; });
    EXPECT_GE(seen.drifted_at, 0) << rows;
    EXPECT_LT(seen.drifted_at, 30) << rows;
    EXPECT_NEAR(seen.last.shift_px, rows, 0.05) << rows;
    EXPECT_NEAR(seen.last.rotation_rad, 0, 0.02 * degree) << rows;
    EXPECT_EQ(seen.last.drifts, 1u) << rows;
  }
}

TEST_F(Watch, a_rotation_of_a_fifth_of_a_degree_is_said_within_a_second_and_told_from_a_shift) {
  for (double angle : {0.2 * degree, -0.2 * degree}) {
    const Seen seen = run(40, [&](Calibration& c) { turn(c, angle); });
    EXPECT_GE(seen.drifted_at, 0) << angle;
    EXPECT_LT(seen.drifted_at, 30) << angle;
    EXPECT_NEAR(seen.last.rotation_rad, angle, 0.01 * degree) << angle;
    EXPECT_NEAR(seen.last.shift_px, 0, 0.12) << angle;
  }
}

TEST_F(Watch, what_is_below_the_limit_is_no_alarm_and_the_limit_is_the_configurations) {
  const auto shifted = [](Calibration& c) { (*c.raw)[1].projection[6] += 0.3; };
  EXPECT_EQ(run(40, shifted).last.state, CalibrationState::good);
  config_.image_source.rowLimit = 0.2;
  EXPECT_EQ(run(40, shifted).last.state, CalibrationState::drifted);
}

TEST_F(Watch, without_texture_there_is_no_verdict) {
  config_.sim.texture = 0;
  const Seen seen = run(40);
  EXPECT_EQ(seen.last.state, CalibrationState::measuring);
  EXPECT_TRUE(std::isnan(seen.last.median_px));
}

class RealSets : public Watch {
 protected:
  /// State and points after some frames of a recording.
  void expect_good(const std::string& left, const std::string& right, const std::string& calibration, double rate, int ndisp, int frames) {
    const std::filesystem::path data(VDISP_SHARED_DATA);
    if (!std::filesystem::exists(data / calibration)) GTEST_SKIP() << "no " << (data / calibration).string();
    auto& p = config_.image_source;
    p.source = "files";
    p.left = data / left;
    p.right = data / right;
    p.paramfile = data / calibration;
    p.rate = rate;
    p.ndisp = ndisp;
    p.loop = true;
    const Seen seen = run(frames);
    EXPECT_EQ(seen.last.state, CalibrationState::good) << seen.last.points;
    EXPECT_EQ(seen.last.drifts, 0u) << seen.last.shift_px << " px, " << seen.last.rotation_rad / degree << " deg";
    std::printf("%s: %u points, median %.3f px, 90 %% %.3f px, shift %.3f px, rotation %.3f deg\n", left.c_str(), seen.last.points,
                seen.last.median_px, seen.last.p90_px, seen.last.shift_px, seen.last.rotation_rad / degree);
  }
};

TEST_F(RealSets, kitti_street) {
  expect_good("kitti_street/left/%06d.png", "kitti_street/right/%06d.png", "kitti_street/calibration.yml", 10, 96, 120);
}
TEST_F(RealSets, robot_indoor) {
  expect_good("robot_indoor/robotL.mp4", "robot_indoor/robotR.mp4", "robot_indoor/calibration.yml", 15, 48, 228);
}
TEST_F(RealSets, rover_minnie) {
  expect_good("rover_minnie/rectified/left/*.png", "rover_minnie/rectified/right/*.png", "rover_minnie/rectified/calibration.yml", 10, 128,
              60);
}
TEST_F(RealSets, rover_minnie_raw) {
  expect_good("rover_minnie/raw/left/*.png", "rover_minnie/raw/right/*.png", "rover_minnie/raw/calibration_opencv.yml", 10, 192, 40);
}
TEST_F(RealSets, euroc) { expect_good("euroc/mav0/cam0/data/*.png", "euroc/mav0/cam1/data/*.png", "euroc", 20, 48, 90); }

TEST(RowPoints, the_line_is_found_among_a_third_of_wrong_matches) {
  std::minstd_rand random(3);
  const auto draw = [&random](double low, double high) { return static_cast<float>(std::uniform_real_distribution(low, high)(random)); };
  RowPoints points;
  for (int i = 0; i < 700; ++i) {
    const float x = draw(-320, 320), y = draw(-240, 240);
    points.add({x, y, i % 3 == 0 ? draw(-5, 5) : 0.7f + 0.004f * x - 0.001f * y + draw(-0.1, 0.1), i});
  }
  const RowLine line = points.fit();
  EXPECT_NEAR(line.shift, 0.7, 0.02);
  EXPECT_NEAR(line.rotation, 0.004, 1e-4);
  EXPECT_LT(line.shift_deviation, 0.02);
  EXPECT_NEAR(line.shift, 0.7, 4 * line.shift_deviation);
}

TEST(RowPoints, the_newest_are_kept_and_time_that_runs_back_begins_anew) {
  RowPoints points;
  for (int i = 0; i < RowPoints::capacity + 10; ++i) points.add({0, 0, 0, i});
  EXPECT_EQ(points.count(), RowPoints::capacity);
  EXPECT_EQ(points.oldest_ns(), 10);
  points.forget_before(20);
  EXPECT_EQ(points.oldest_ns(), 20);
  points.add({0, 0, 0, 5});
  EXPECT_EQ(points.count(), 1);
}

}  // namespace
}  // namespace vdisp
