// frames_test.cpp: the frames agree with the papers and with each other.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/geometry/frames.h"

#include <gtest/gtest.h>

namespace vdisp {
namespace {

constexpr double degree = M_PI / 180;
const StereoView paper{576, 320, 240, 0.09, 0};  // 6 mm lens at 640 px (paper, section 2.2)

TEST(Frames, horizontal_is_equation_3_of_the_paper) {
  const double t = 0.26;
  const Point h = horizontal({1, 2, 3}, t);
  EXPECT_DOUBLE_EQ(h.x, 1);
  EXPECT_DOUBLE_EQ(h.y, 2 * std::cos(t) + 3 * std::sin(t));
  EXPECT_DOUBLE_EQ(h.z, 3 * std::cos(t) - 2 * std::sin(t));
}

TEST(Frames, camera_undoes_horizontal) {
  const Point c{0.3, -0.7, 2.5};
  const Point back = camera(horizontal(c, 0.4, 0.1), 0.4, 0.1);
  EXPECT_NEAR(back.x, c.x, 1e-12);
  EXPECT_NEAR(back.y, c.y, 1e-12);
  EXPECT_NEAR(back.z, c.z, 1e-12);
}

TEST(Frames, looking_down_puts_the_axis_below_the_horizon) { EXPECT_GT(horizontal({0, 0, 1}, 0.2).y, 0); }

TEST(Frames, rolling_right_side_low_puts_the_right_below_the_left) {
  EXPECT_GT(horizontal({1, 0, 5}, 0, 0.1).y, horizontal({-1, 0, 5}, 0, 0.1).y);
}

TEST(Frames, nearest_floor_is_the_papers_one_meter) {
  EXPECT_NEAR(nearest_floor(0.80, 15 * degree, 22.6 * degree), 1.04, 0.005);
  // Equation 1 as printed.
  EXPECT_GT(std::abs(std::tan(22.6 * degree * 15 * degree) * 0.80 - 1.0), 0.9);
}

TEST(Frames, the_papers_camera_matches_all_the_floor_it_sees_but_no_obstacle_nearer_than_its_depth_of_1_08) {
  const double depth = nearest_matched(paper, 48);
  EXPECT_NEAR(depth, 1.08, 1e-9);
  // Along the floor that is 0.90 m ahead, nearer than the lowest row looks.
  EXPECT_NEAR(floor_ahead(depth, 0.80, 15 * degree), 0.904, 0.001);
  const Point on_floor = horizontal(camera({0, 0.80, floor_ahead(depth, 0.80, 15 * degree)}, 15 * degree), 15 * degree);
  EXPECT_NEAR(camera(on_floor, 15 * degree).z, depth, 1e-9);
}

TEST(Frames, floor_points_lie_on_the_floor_line) {
  const double height = 0.8, pitch = 15 * degree;
  const FloorLine line = floor_line(paper, height, pitch);
  for (double z : {1.1, 2.0, 4.0}) {
    const Point c = camera({0.4, height, z}, pitch);
    const double v = paper.cy + paper.f * c.y / c.z;
    EXPECT_NEAR(line.row(paper.disparity(c.z)), v, 1e-9);
  }
}

TEST(Frames, pitch_and_height_come_back_from_the_floor_line) {
  const FloorPose pose = floor_pose(paper, floor_line(paper, 1.67, 35.3 * degree));
  EXPECT_NEAR(pose.height, 1.67, 1e-12);
  EXPECT_NEAR(pose.pitch, 35.3 * degree, 1e-12);
}

TEST(Frames, disparity_counts_from_the_difference_of_the_optical_centres) {
  StereoView view = paper;
  view.cx_offset = 12;
  EXPECT_NEAR(view.point(320, 240, view.disparity(2.0)).z, 2.0, 1e-12);
  EXPECT_NEAR(view.disparity(1e12), 12, 1e-6);
}

TEST(Frames, rover_frame_is_forward_left_up) {
  const Point r = rover({0.5, 0.8, 2.0}, 0.1, 0, 0, 0.8);
  EXPECT_NEAR(r.x, 2.1, 1e-12);
  EXPECT_NEAR(r.y, -0.5, 1e-12);
  EXPECT_NEAR(r.z, 0, 1e-12);
}

}  // namespace
}  // namespace vdisp
