// segments_test.cpp: obstacles without a floor model; truth from points of planes, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/segments.h"

#include "tests/support/plane_scene.h"

namespace vdisp {
namespace {

/// The paper's first approach, for comparison.
struct SegmentsTest : PlaneScene {
  std::vector<std::unique_ptr<Picture>> shown;
  Picture model_of_floor{record_spec<FloorModel>()};

  Outcome segment() {
    Segments segments(config);
    return run_stage(segments, {&disparity, &model_of_floor}, shown);
  }
  /// Share of the pixels of rows and columns that are obstacles.
  double blocked(int top, int bottom, int from, int to) {
    int count = 0;
    for (int v = top; v < bottom; ++v)
      for (int u = from; u < to; ++u) count += shown[1]->at<uint8_t>(v, u) != 0;
    return static_cast<double>(count) / ((bottom - top) * (to - from));
  }
  void SetUp() override {
    PlaneScene::SetUp();
    config.limit.angRot = config.map.angRot = pitch;
    model_of_floor.image().set_blind(Reason::no_floor);
  }
};

TEST_F(SegmentsTest, a_wall_is_an_obstacle_and_the_ground_is_none_without_a_floor_model) {
  see(with_wall(ground(high), 2.55, 0.5, -0.4, 0.4));
  ASSERT_EQ(segment(), Outcome::valid);
  const Point foot = camera({0, high, 2.55}, pitch), top = camera({0, high - 0.5, 2.55}, pitch), side = camera({0.4, high, 2.55}, pitch);
  const int low = static_cast<int>(view.cy + view.f * foot.y / foot.z), edge = static_cast<int>(view.cy + view.f * top.y / top.z),
            half = static_cast<int>(view.f * side.x / side.z);
  EXPECT_GT(blocked(edge + 3, low - 5, 160 - half + 3, 160 + half - 3), 0.95);
  EXPECT_LT(blocked(low + 6, height, 5, width - 5), 0.02);
}

TEST_F(SegmentsTest, what_rises_by_more_than_max_height_is_an_obstacle_however_gentle_its_slope) {
  config.floor.maxSlope = 1;
  config.limit.angRot = config.map.angRot = static_cast<float>(pitch + 0.1);  // level ground seems to rise
  const Scene flat = ground(high);
  see([&](const Point& ray) { return flat(ray) < 5 ? flat(ray) : 0; });
  for (const auto& [max_height, share] : {std::pair{2.0f, 0.0}, {0.05f, 0.9}}) {
    config.limit.max_height = max_height;
    ASSERT_EQ(segment(), Outcome::valid);
    EXPECT_NEAR(blocked(height / 2, height, 0, width), share, 0.1) << max_height;
  }
}

TEST_F(SegmentsTest, with_a_pitch_from_the_floor_it_is_blind_where_there_is_none) {
  config.limit.angRot = config.map.angRot = std::nanf("");
  see(ground(high));
  EXPECT_EQ(segment(), Outcome::invalid);
  EXPECT_EQ(shown[0]->image().reason, Reason::no_pitch);
}

TEST_F(SegmentsTest, it_joins_what_hangs_together_and_drops_what_is_small) {
  see(with_wall(with_wall(ground(high), 2.5, 0.6, -0.6, -0.2), 1.8, 0.6, 0.2, 0.6));
  ASSERT_EQ(segment(), Outcome::valid);
  const auto at = [&](double right, double up, double ahead) {
    const Point c = camera({right, high - up, ahead}, pitch);
    return shown[0]->at<uint8_t>(static_cast<int>(view.cy + view.f * c.y / c.z), static_cast<int>(view.cx + view.f * c.x / c.z));
  };
  const int near = at(0.4, 0.3, 1.8), far = at(-0.4, 0.3, 2.5);
  EXPECT_NE(near, 0);
  EXPECT_NE(far, 0);
  EXPECT_NE(near, far);
  EXPECT_EQ(near, at(0.3, 0.5, 1.8));
  config.image_source.SpeckleSize = 10000;
  ASSERT_EQ(segment(), Outcome::valid);
  EXPECT_EQ(at(0.4, 0.3, 1.8), 0);
}

}  // namespace
}  // namespace vdisp
