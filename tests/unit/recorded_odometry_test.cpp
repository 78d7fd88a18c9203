// recorded_odometry_test.cpp: poses of both kinds become the rover's, in the odometry frame of REP-103.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/recorded_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "daemon/sources/source.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

struct RecordedOdometryTest : testing::Test {
  TemporaryFolder folder;
  mounting_section mounting;
  RecordedOdometry file(const std::string& text) {
    const std::string path = (folder.path() / "poses").string();
    std::ofstream(path) << text;
    return RecordedOdometry(path);
  }
  void refused(const std::string& text, const std::string& why) {
    try {
      file(text);
      ADD_FAILURE() << "not refused: " << text;
    } catch (const SourceError& error) {
      EXPECT_EQ(error.exit_code, 78);
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
};

TEST_F(RecordedOdometryTest, kitti_ahead_is_x_right_is_minus_y_and_a_left_turn_is_positive) {
  // 0.1 rad to the left about the vertical: the view goes to -X of the first camera.
  const double c = std::cos(0.1), s = std::sin(0.1);
  std::ostringstream text;
  text.precision(17);
  text << "1 0 0 0 0 1 0 0 0 0 1 0\n" << c << " 0 " << -s << " 2 0 1 0 0.5 " << s << " 0 " << c << " 3\n";
  const RecordedOdometry poses = file(text.str());
  const Odometry pose = poses.at(1, 42, mounting);
  EXPECT_NEAR(pose.x, 3, 1e-12);
  EXPECT_NEAR(pose.y, -2, 1e-12);
  EXPECT_NEAR(pose.z, -0.5, 1e-12);
  EXPECT_NEAR(pose.yaw, 0.1, 1e-12);
  EXPECT_NEAR(pose.pitch, 0, 1e-12);
  EXPECT_NEAR(pose.roll, 0, 1e-12);
  EXPECT_EQ(pose.timestamp_ns, 42);
  EXPECT_TRUE(std::isnan(poses.at(2, 0, mounting).x)) << "the file has two";
}

TEST_F(RecordedOdometryTest, kitti_nose_down_is_positive_pitch_and_right_side_low_positive_roll) {
  const double c = std::cos(0.2), s = std::sin(0.2);
  std::ostringstream text;
  text.precision(17);
  text << "1 0 0 0 0 " << c << " " << s << " 0 0 " << -s << " " << c << " 0\n"
       << c << " " << -s << " 0 0 " << s << " " << c << " 0 0 0 0 1 0\n";
  const RecordedOdometry poses = file(text.str());
  EXPECT_NEAR(poses.at(0, 0, mounting).pitch, 0.2, 1e-12);
  EXPECT_NEAR(poses.at(1, 0, mounting).roll, 0.2, 1e-12);
}

TEST_F(RecordedOdometryTest, kitti_poses_are_the_cameras_and_mounting_makes_them_the_rovers) {
  mounting.x = 1;
  mounting.y = 0.5;
  mounting.yaw = M_PI / 2;
  const Odometry pose = file("1 0 0 0 0 1 0 0 0 0 1 0\n").at(0, 0, mounting);
  EXPECT_NEAR(pose.yaw, -M_PI / 2, 1e-12) << "the camera looks to the left of a rover that heads to the right";
  EXPECT_NEAR(pose.x, -0.5, 1e-12) << "its left is ahead";
  EXPECT_NEAR(pose.y, 1, 1e-12);
}

TEST_F(RecordedOdometryTest, csv_by_time_is_interpolated_and_by_frame_is_not) {
  const RecordedOdometry timed = file("timestamp_ns, x, y, yaw, speed\n0,0,0,3.1,1\n100000000,1,2,-3.1,1\n2000000000,5,5,0,1\n");
  const Odometry half = timed.at(0, 50'000'000, mounting);
  EXPECT_NEAR(half.x, 0.5, 1e-12);
  EXPECT_NEAR(half.y, 1, 1e-12);
  EXPECT_NEAR(std::abs(half.yaw), M_PI, 1e-9) << "the short way round";
  EXPECT_EQ(half.speed, 1);
  EXPECT_TRUE(std::isnan(half.z));
  EXPECT_TRUE(std::isnan(timed.at(0, 1'000'000'000, mounting).x)) << "a gap of 1.9 s";
  EXPECT_TRUE(std::isnan(timed.at(0, -1, mounting).x));
  EXPECT_TRUE(std::isnan(timed.at(0, 2'000'000'001, mounting).x));
  const RecordedOdometry numbered = file("frame,x,y,yaw\n0,1,0,0\n2,3,0,0\n");
  EXPECT_EQ(numbered.at(2, 0, mounting).x, 3);
  EXPECT_TRUE(std::isnan(numbered.at(1, 0, mounting).x)) << "no pose of this frame";
}

TEST_F(RecordedOdometryTest, what_is_neither_kind_is_refused_with_its_line) {
  refused("", "empty");
  refused("1 2 3\n", "line 1: must be 12 numbers");
  refused("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 nan\n", "line 2");
  refused("1 0 0 0 0 1 0 0 0 0 1 0 5\n", "12 numbers");
  refused("x,y\n", "must name the columns");
  refused("frame,timestamp_ns,x,y,yaw\n", "timestamp_ns or frame");
  refused("frame,x,y,yaw\n0,1,2\n", "line 2: 3 fields");
  refused("frame,x,y,yaw\n0,1,b,0\n", "y = 'b'");
  refused("frame,x,y,yaw\n0,1,nan,0\n", "finite");
  refused("frame,x,y,yaw\n0,1e5,0,0\n1,0,-100001,0\n", "line 3: x and y must be within 100 km");
  refused("frame,x,y,yaw\n1,0,0,0\n1,0,0,0\n", "line 3: frame 1 is not after");
  EXPECT_THROW(RecordedOdometry("/nonexistent/poses"), SourceError);
}

}  // namespace
}  // namespace vdisp
