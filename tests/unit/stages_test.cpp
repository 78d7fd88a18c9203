// stages_test.cpp: from disparity to map, each stage against the paper's algorithm and arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/stages/floor.h"
#include "daemon/stages/height.h"
#include "daemon/stages/limit.h"
#include "daemon/stages/map.h"
#include "daemon/stages/projection.h"
#include "daemon/stages/show_line.h"
#include "daemon/stages/show_obstacle.h"
#include "daemon/stages/vdisparity.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

const StereoView paper{576, 320, 240, 0.09, 0};
constexpr double paper_height = 0.8, paper_pitch = 0.26;
constexpr int width = 640, height = 480;

CameraGeometry geometry(const StereoView& view, int ndisp, int min_disparity = 0) {
  return {static_cast<float>(view.f),
          static_cast<float>(view.cx),
          static_cast<float>(view.cy),
          static_cast<float>(view.baseline),
          static_cast<float>(view.cx_offset),
          min_disparity,
          ndisp,
          {}};
}

struct StagesTest : testing::Test {
  Config config;
  Machine machine;
  std::vector<std::unique_ptr<Picture>> out, floor, limit;
  Picture disparity{Pixel::disparity16, width, height};
  Picture vdisparity{Pixel::count16, 768, height};

  void SetUp() override {
    disparity.image().camera = vdisparity.image().camera = geometry(paper, 48);
    disparity.fill<int16_t>([](int, int) { return rejected(Rejected::low_texture); });
  }
  // Votes along a line of the v-disparity, as a flat floor gives them.
  void draw_line(double slope, double row0, int16_t votes) {
    for (int column = 0; column < 768; ++column) {
      const long row = std::lround(slope * column + row0);
      if (row >= 0 && row < height) vdisparity.at<int16_t>(static_cast<int>(row), column) = votes;
    }
  }
  Outcome find_floor(uint64_t sequence = 0) {
    vdisparity.image().sequence = sequence;
    Floor stage(machine, config);
    return run_stage(stage, {&vdisparity}, floor);
  }
  const FloorModel& model() { return *record_of<FloorModel>(floor.at(1)->image()); }
  void exact_floor(double h, double pitch) {
    const FloorLine line = floor_line(paper, h, pitch);
    draw_line(line.slope / 16, line.row0, 100);
    ASSERT_EQ(find_floor(), Outcome::valid);
    // The line is found from whole cells; what follows is tested against the exact one.
    floor[1]->image().row<FloorModel>(0)->a = line.slope / 16;
    floor[1]->image().row<FloorModel>(0)->b = line.row0;
  }
  void find_limit() {
    Limit stage(config);
    ASSERT_EQ(run_stage(stage, {floor[0].get(), floor[1].get()}, limit), Outcome::valid);
  }
  // What a point of frame h becomes in the disparity image, at the nearest pixel and 1/16 px.
  void see(const Point& h) {
    const Point c = camera(h, paper_pitch);
    const int u = static_cast<int>(std::lround(paper.cx + paper.f * c.x / c.z)),
              v = static_cast<int>(std::lround(paper.cy + paper.f * c.y / c.z));
    ASSERT_TRUE(u >= 0 && u < width && v >= 0 && v < height) << u << ' ' << v;
    disparity.at<int16_t>(v, u) = static_cast<int16_t>(std::lround(16 * paper.disparity(c.z)));
  }
  void make_map() {
    Map stage(machine, config);
    ASSERT_EQ(run_stage(stage, {&disparity, limit[0].get(), floor[1].get()}, out), Outcome::valid);
  }
  int total(Picture& map) {
    int sum = 0;
    for (int r = 0; r < map.spec().height; ++r)
      for (int c = 0; c < map.spec().width; ++c) sum += map.at<int16_t>(r, c);
    return sum;
  }
};

TEST_F(StagesTest, vdisparity_counts_each_disparity_in_its_row) {
  disparity.at<int16_t>(7, 100) = disparity.at<int16_t>(7, 300) = 5 * 16 + 3;
  disparity.at<int16_t>(8, 100) = 1;
  disparity.at<int16_t>(9, 100) = 0;  // infinity is no vote (algorithm 1: disp > 0)
  VDisparity stage(machine, config);
  ASSERT_EQ(run_stage(stage, {&disparity}, out), Outcome::valid);
  EXPECT_EQ(out[0]->spec(), (ImageSpec{Pixel::count16, 0, 768, height}));
  EXPECT_EQ(out[0]->at<int16_t>(7, 83), 2);
  EXPECT_EQ(out[0]->at<int16_t>(8, 1), 1);
  EXPECT_EQ(total(*out[0]), 3);
}

TEST_F(StagesTest, vdisparity_columns_begin_at_the_least_disparity) {
  config.image_source.minDisparity = 10;
  config.image_source.ndisp = 32;
  disparity.image().camera = geometry(paper, 32, 10);
  disparity.at<int16_t>(0, 0) = 10 * 16 + 5;
  disparity.at<int16_t>(0, 1) = 42 * 16;  // beyond the search
  VDisparity stage(machine, config);
  ASSERT_EQ(run_stage(stage, {&disparity}, out), Outcome::valid);
  EXPECT_EQ(out[0]->at<int16_t>(0, 5), 1);
  EXPECT_EQ(total(*out[0]), 1);
}

TEST_F(StagesTest, floor_finds_pitch_and_height_of_a_drawn_line) {
  const FloorLine line = floor_line(paper, paper_height, paper_pitch);
  draw_line(line.slope / 16, line.row0, 50);
  ASSERT_EQ(find_floor(), Outcome::valid);
  EXPECT_NEAR(model().pitch_rad, paper_pitch, 0.001);
  EXPECT_NEAR(model().height_m, paper_height, 0.004);
  EXPECT_EQ(model().state, FloorState::found);
  EXPECT_NEAR(model().confidence, 1, 1e-9);
}

TEST_F(StagesTest, floor_finds_line_with_half_outliers) {
  const FloorLine line = floor_line(paper, paper_height, paper_pitch);
  std::mt19937 random(5);
  for (int i = 0; i < 700; ++i) vdisparity.at<int16_t>(static_cast<int>(random() % height), static_cast<int>(random() % 768)) = 50;
  draw_line(line.slope / 16, line.row0, 50);
  for (uint64_t frame = 0; frame < 50; ++frame) {
    ASSERT_EQ(find_floor(frame), Outcome::valid);
    EXPECT_NEAR(model().pitch_rad, paper_pitch, 0.005) << frame;
    EXPECT_NEAR(model().height_m, paper_height, 0.01) << frame;
  }
}

TEST_F(StagesTest, floor_keeps_the_best_line_not_the_last) {
  // Algorithm 2 as printed never updates no_point_best: any later line with a point near it would win, here one of the short ones.
  draw_line(0.5, 100, 50);
  for (int column = 0; column < 60; ++column) vdisparity.at<int16_t>(static_cast<int>(300 + 0.8 * column), column) = 50;
  config.floor.iterRansac = 200;
  for (uint64_t frame = 0; frame < 20; ++frame) {
    ASSERT_EQ(find_floor(frame), Outcome::valid);
    EXPECT_NEAR(model().a, 0.5, 0.005) << frame;
  }
}

TEST_F(StagesTest, floor_is_not_clipped_to_the_image) {
  draw_line(0.8, 100, 50);
  ASSERT_EQ(find_floor(), Outcome::valid);
  EXPECT_NEAR(floor[0]->at<int16_t>(0, 767), 0.8 * 767 + 100, 2);  // 714, below the picture; the paper writes 0
}

TEST_F(StagesTest, a_frame_gives_the_same_floor_every_time) {
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) vdisparity.at<int16_t>(static_cast<int>(random() % height), static_cast<int>(random() % 768)) = 50;
  find_floor(42);
  const double a = model().a;
  find_floor(43);
  find_floor(42);
  EXPECT_EQ(model().a, a);
}

TEST_F(StagesTest, without_points_the_floor_is_lost_and_says_why) {
  EXPECT_EQ(find_floor(), Outcome::invalid);
  EXPECT_EQ(floor[0]->image().reason, Reason::few_points);
  EXPECT_EQ(model().state, FloorState::lost);
  EXPECT_EQ(model().reason, Reason::few_points);
}

TEST_F(StagesTest, an_upright_line_is_no_floor) {
  for (int v = 0; v < height; ++v) vdisparity.at<int16_t>(v, 300) = 50;
  EXPECT_EQ(find_floor(), Outcome::invalid);
  EXPECT_EQ(floor[0]->image().reason, Reason::no_floor_line);
}

TEST_F(StagesTest, without_calibration_there_is_a_line_but_no_metres) {
  vdisparity.image().camera = disparity.image().camera = geometry({}, 48);
  draw_line(0.5, 100, 50);
  ASSERT_EQ(find_floor(), Outcome::valid);
  EXPECT_NEAR(model().a, 0.5, 0.005);
  EXPECT_TRUE(std::isnan(model().pitch_rad) && std::isnan(model().height_m));
  Limit stage(config);
  EXPECT_EQ(run_stage(stage, {floor[0].get(), floor[1].get()}, limit), Outcome::invalid);
  EXPECT_EQ(limit[0]->image().reason, Reason::no_calibration);
  Height metres(config);
  EXPECT_EQ(run_stage(metres, {&disparity, floor[1].get()}, out), Outcome::invalid);
  EXPECT_EQ(out[0]->image().reason, Reason::no_calibration);
}

TEST_F(StagesTest, floor_compares_itself_with_the_mounting) {
  config.mounting.height = 0.8;
  exact_floor(paper_height, paper_pitch);
  EXPECT_EQ(model().mounting_differs, 0u);
  config.mounting.height = 1.0;
  find_floor();
  EXPECT_EQ(model().mounting_differs, 1u);
}

// Algorithm 3 of the paper as printed, with height taken along Y as in its section 2.2.
int algorithm_3(double floor_row, double d, double pitch, double max_height) {
  const Point on_floor = horizontal(paper.point(0, floor_row, d), pitch);
  for (int j = static_cast<int>(std::ceil(floor_row)) - 1;; --j) {
    const Point above = horizontal(paper.point(0, j, d), pitch);
    if (std::abs(above.y - on_floor.y) > max_height) return j;
  }
}

TEST_F(StagesTest, limit_agrees_with_algorithm_3_of_the_paper) {
  for (double pitch : {0.0, paper_pitch, 0.6}) {
    for (double max_height : {0.1, 0.2, 0.5}) {
      config.limit.angRot = config.limit.max_height = max_height;
      config.limit.angRot = pitch;
      exact_floor(paper_height, paper_pitch);
      find_limit();
      for (int column = 1; column < 768; ++column) {
        const double d = column / 16.0;
        ASSERT_EQ(limit[0]->at<int16_t>(0, column), algorithm_3(16 * model().a * d + model().b, d, pitch, max_height)) << column;
      }
      EXPECT_EQ(limit[0]->at<int16_t>(0, 0), line_none);  // infinity
    }
  }
}

TEST_F(StagesTest, limit_takes_the_measured_pitch_when_asked) {
  exact_floor(paper_height, 0.4);
  config.limit.angRot = 0.4;
  find_limit();
  const int configured = limit[0]->at<int16_t>(0, 500);
  config.limit.angRot = word_given;
  find_limit();
  EXPECT_NEAR(limit[0]->at<int16_t>(0, 500), configured, 1);
}

TEST_F(StagesTest, obstacles_are_what_lies_higher_than_max_height) {
  exact_floor(paper_height, paper_pitch);
  find_limit();
  see({0.0, paper_height - 0.25, 2});
  see({0.3, paper_height - 0.15, 2});
  see({-0.3, paper_height + 0.3, 2});  // below the floor
  ShowObstacle stage(machine);
  ASSERT_EQ(run_stage(stage, {&disparity, limit[0].get()}, out), Outcome::valid);
  int marked = 0;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) marked += out[0]->at<uint8_t>(v, u) != 0;
  EXPECT_EQ(marked, 1);
}

TEST_F(StagesTest, an_obstacle_on_floor_below_the_picture_is_seen) {
  // 0.95 m ahead the floor is not in the picture any more (1.04 m is); its row must not have become 0.
  exact_floor(paper_height, paper_pitch);
  config.image_source.ndisp = 64;
  find_limit();
  const double d = 767 / 16.0;
  EXPECT_GT(floor[0]->at<int16_t>(0, 767), height);
  disparity.at<int16_t>(300, 320) = static_cast<int16_t>(16 * d);
  ShowObstacle stage(machine);
  run_stage(stage, {&disparity, limit[0].get()}, out);
  EXPECT_EQ(out[0]->at<uint8_t>(300, 320), 255);
}

TEST_F(StagesTest, height_is_metres_above_the_floor) {
  exact_floor(paper_height, paper_pitch);
  see({0, paper_height - 0.35, 2});
  Height stage(config);
  ASSERT_EQ(run_stage(stage, {&disparity, floor[1].get()}, out), Outcome::valid);
  int found = 0;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      if (out[0]->at<int16_t>(v, u) != height_unknown) {
        ++found;
        EXPECT_NEAR(out[0]->at<int16_t>(v, u), 350, 8);  // half a row and 1/32 px at 2 m
      }
  EXPECT_EQ(found, 1);
}

TEST_F(StagesTest, map_puts_a_point_where_it_stands) {
  exact_floor(paper_height, paper_pitch);
  find_limit();
  see({0.52, paper_height - 0.4, 2.04});
  make_map();
  EXPECT_EQ(out[0]->spec(), (ImageSpec{Pixel::count16, 0, 51, 50}));
  // Half-open cells: z 2.0..2.1 is row 50 - 1 - 20, x 0.45..0.55 is column 30.
  EXPECT_EQ(out[0]->at<int16_t>(29, 30), 1);
  EXPECT_EQ(total(*out[0]), 1);
}

TEST_F(StagesTest, map_ignores_what_lies_outside_where_algorithm_4_would_write_beyond_it) {
  exact_floor(paper_height, paper_pitch);
  find_limit();
  see({2.6, paper_height - 0.5, 4.95});   // 2.78 m half width at 5 m: column 51 of 0..50
  see({-2.6, paper_height - 0.5, 4.95});  // column -1
  see({0, paper_height - 0.8, 5.3});      // row -1
  make_map();
  EXPECT_EQ(total(*out[0]), 0);
}

TEST_F(StagesTest, map_counts_saturate) {
  exact_floor(paper_height, paper_pitch);
  find_limit();
  config.map.cell = 5;
  config.map.width = 5;
  disparity.fill<int16_t>([](int v, int) { return v < 200 ? int16_t{30 * 16} : rejected(Rejected::outside); });
  make_map();
  EXPECT_EQ(out[0]->at<int16_t>(0, 0), 32767);  // of 128000
}

TEST_F(StagesTest, map_undoes_the_roll_of_the_mounting) {
  exact_floor(paper_height, paper_pitch);
  find_limit();
  see({0, -0.3, 4});  // 1.32 m over the optical axis, straight ahead
  config.mounting.roll = 0.3;
  make_map();
  // Rolled right side low, what the camera sees above its axis lies to the right of it: 1.32 sin 0.3 = 0.39 m.
  int column = -1;
  for (int r = 0; r < 50; ++r)
    for (int c = 0; c < 51; ++c)
      if (out[0]->at<int16_t>(r, c)) column = c;
  EXPECT_EQ(column, 29);
}

TEST_F(StagesTest, map_tells_its_geometry) {
  config.mounting.x = 0.4;
  exact_floor(paper_height, paper_pitch);
  find_limit();
  make_map();
  const GridGeometry& g = out[0]->image().grid;
  EXPECT_FLOAT_EQ(g.cell, 0.1f);
  EXPECT_FLOAT_EQ(g.origin_row, 50);
  EXPECT_FLOAT_EQ(g.origin_column, 25.5f);
  EXPECT_NEAR(g.view_right, 320 / 576.0 / std::cos(paper_pitch), 1e-5);
  EXPECT_EQ(g.min_count, 3u);
  EXPECT_FLOAT_EQ(g.pose_x, 0.4f);
}

TEST_F(StagesTest, show_line_draws_the_line_where_it_is) {
  draw_line(0.5, 100, 50);
  find_floor();
  ShowLine stage({255, 0, 0});
  ASSERT_EQ(run_stage(stage, {&vdisparity, floor[0].get()}, out), Outcome::valid);
  const int row = floor[0]->at<int16_t>(0, 400);
  EXPECT_EQ(out[0]->image().row<uint8_t>(row)[3 * 400], 255);
  EXPECT_EQ(out[0]->image().row<uint8_t>(row)[3 * 400 + 1], 0);
  EXPECT_EQ(out[0]->image().row<uint8_t>(row - 20)[3 * 400], 0);
}

TEST_F(StagesTest, wrong_inputs_are_refused_with_what_was_found) {
  Limit stage(config);
  try {
    stage.accept(disparity.spec(), disparity.spec());
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "the floor is disparity16, needed is line16");
  }
  ShowLine show({0, 0, 0});
  EXPECT_THROW(show.accept(vdisparity.spec(), {Pixel::line16, 0, 512, 1}), FormatError);
}

}  // namespace
}  // namespace vdisp
