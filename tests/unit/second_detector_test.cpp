// second_detector_test.cpp: from two drawn views with known disparities to the scores of classifiers whose weights are known.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "daemon/stages/census_disparity.h"
#include "daemon/stages/census_view.h"
#include "daemon/stages/classify.h"
#include "daemon/stages/depth_map.h"
#include "daemon/stages/features.h"
#include "daemon/stages/smoothed_view.h"
#include "tests/support/count_allocations.h"
#include "tests/support/picture.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

constexpr int width = 320, height = 240;
constexpr int far_px = 5, near_px = 21;
/// A box in the left view, nearer than the wall behind it.
constexpr bool in_box(int row, int column) { return row >= 80 && row < 200 && column >= 200 && column < 280; }

/// Grey levels of a wall and of the box's face, random but the same wherever they are seen from.
struct Scene {
  std::vector<uint8_t> wall, box;
  Scene() : wall(1000 * height), box(1000 * height) {
    std::minstd_rand random(3);
    for (auto* surface : {&wall, &box})
      for (uint8_t& grey : *surface) grey = static_cast<uint8_t>(60 + (random() >> 8) % 120);
  }
  /// As seen from `shift` baselines to the right of the left camera.
  uint8_t grey(int row, int column, int shift) const {
    const int on_box = column + shift * near_px, on_wall = column + shift * far_px;
    return in_box(row, on_box) ? box[static_cast<size_t>(row * 1000 + on_box)] : wall[static_cast<size_t>(row * 1000 + on_wall)];
  }
};

struct SecondDetectorTest : testing::Test {
  Config config;
  Machine machine{2};
  Scene scene;
  Picture left{Pixel::gray8, width, height}, right{Pixel::gray8, width, height};
  std::vector<std::unique_ptr<Picture>> out;

  SecondDetectorTest() {
    config.census.scale = 1;
    left.fill<uint8_t>([&](int row, int column) { return scene.grey(row, column, 0); });
    right.fill<uint8_t>([&](int row, int column) { return scene.grey(row, column, 1); });
    for (Picture* view : {&left, &right}) view->image().camera = {288, 160, 120, 0.1f, 0, 0, 0, {}};
  }
  std::unique_ptr<Picture> run(ImageProcessor&& stage, std::vector<Picture*> in, Outcome expected = Outcome::valid) {
    EXPECT_EQ(run_stage(stage, std::move(in), out), expected);
    return std::move(out.at(0));
  }
  std::unique_ptr<Picture> census(Picture& view) {
    const auto smooth = run(SmoothedView(machine, config), {&view});
    return run(CensusView(machine), {smooth.get()});
  }
  std::unique_ptr<Picture> disparity(Outcome expected = Outcome::valid) {
    const auto l = census(left), r = census(right);
    return run(CensusDisparity(machine, config), {l.get(), r.get(), &left}, expected);
  }
};

TEST_F(SecondDetectorTest, smaller_views_have_the_geometry_of_what_they_show) {
  config.census.scale = 2;
  config.census.smooth = "none";
  const auto small = run(SmoothedView(machine, config), {&left});
  EXPECT_EQ(small->spec(), (ImageSpec{Pixel::gray8, 0, 160, 120}));
  const int sum = left.at<uint8_t>(20, 30) + left.at<uint8_t>(20, 31) + left.at<uint8_t>(21, 30) + left.at<uint8_t>(21, 31);
  EXPECT_EQ(small->at<uint8_t>(10, 15), (sum + 2) / 4);
  const CameraGeometry& g = small->image().camera;
  EXPECT_FLOAT_EQ(g.f, 144);
  EXPECT_FLOAT_EQ(g.cx, 79.75f) << "the middle of the first pixel was at 0.5";
  EXPECT_FLOAT_EQ(g.baseline, 0.1f);
  config.census.smooth = "mean";
  const auto mean = run(SmoothedView(machine, config), {&left});
  int nine = 0;
  for (int i = 0; i < 9; ++i) nine += small->at<uint8_t>(9 + i / 3, 14 + i % 3);
  EXPECT_EQ(mean->at<uint8_t>(10, 15), (nine + 4) / 9);
  config.census.scale = 8;
  EXPECT_THROW(run(SmoothedView(machine, config), {&left}), FormatError) << "40x30 is less than the features need";
}

TEST_F(SecondDetectorTest, without_smoothing_a_view_is_as_it_was) {
  config.census.smooth = "none";
  const auto same = run(SmoothedView(machine, config), {&left});
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) ASSERT_EQ(same->at<uint8_t>(row, column), left.at<uint8_t>(row, column));
}

TEST_F(SecondDetectorTest, a_wall_and_a_box_have_their_disparities) {
  for (const char* smooth : {"none", "mean", "median"}) {
    config.census.smooth = smooth;
    const auto found = disparity();
    EXPECT_EQ(found->image().camera.disparities, 32);
    int wrong = 0, all = 0;
    for (int row = 6; row < height - 6; ++row) {
      for (int column = 50; column < width - 6; ++column) {
        // Within a window of an edge of the box either may be right, and what the box hides from the right camera has none.
        bool edge = false;
        for (const int v : {-6, 6})
          for (const int u : {-6, 6, near_px - far_px + 6}) edge = edge || in_box(row + v, column + u) != in_box(row, column);
        if (edge) continue;
        ++all;
        wrong += found->at<int16_t>(row, column) != 16 * (in_box(row, column) ? near_px : far_px);
      }
    }
    EXPECT_GT(all, 30000);
    EXPECT_LE(wrong, all / 1000) << smooth;
  }
}

TEST_F(SecondDetectorTest, brightness_and_contrast_of_a_camera_change_nothing) {
  config.census.smooth = "none";
  const auto before = disparity();
  // Grey levels are 60 to 179. A gain above 1: with less, levels that differed become the same one.
  const std::function<int(int)> changes[] = {[](int grey) { return grey + 20; }, [](int grey) { return grey * 7 / 5; },
                                             [](int grey) { return grey * 2 - 110; }};
  for (const auto& change : changes) {
    right.fill<uint8_t>([&](int row, int column) { return static_cast<uint8_t>(change(scene.grey(row, column, 1))); });
    const auto after = disparity();
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) ASSERT_EQ(before->at<int16_t>(row, column), after->at<int16_t>(row, column));
  }
}

TEST_F(SecondDetectorTest, confidence_refuses_even_surfaces_and_the_more_of_them_the_higher_it_is) {
  left.fill<uint8_t>([&](int row, int column) { return row < 120 ? scene.grey(row, column, 0) : uint8_t{128}; });
  right.fill<uint8_t>([&](int row, int column) { return row < 120 ? scene.grey(row, column, 1) : uint8_t{128}; });
  const auto found = disparity();
  for (int row = 130; row < height - 6; ++row)
    for (int column = 60; column < width - 6; ++column) ASSERT_EQ(found->at<int16_t>(row, column), rejected(Rejected::low_texture));
  config.census.confidence = 0;
  EXPECT_EQ(disparity()->at<int16_t>(180, 100), 0) << "of equals the smallest shift";
}

TEST_F(SecondDetectorTest, nothing_to_see_is_said) {
  const auto blinded = [&](const std::function<uint8_t(int, int)>& grey) {
    left.fill<uint8_t>(grey);
    right.fill<uint8_t>(grey);
    return disparity(Outcome::invalid)->image().reason;
  };
  std::minstd_rand random(1);
  EXPECT_EQ(blinded([&](int, int) { return static_cast<uint8_t>((random() >> 8) % 6); }), Reason::too_dark) << "noise under a lens cap";
  EXPECT_EQ(blinded([](int, int) { return uint8_t{255}; }), Reason::too_bright);
  EXPECT_EQ(blinded([](int, int) { return uint8_t{128}; }), Reason::no_texture);
}

TEST_F(SecondDetectorTest, the_depth_map_counts_each_columns_disparities) {
  const auto found = disparity();
  const auto depths = run(DepthMap(machine, config), {found.get()});
  ASSERT_EQ(depths->spec(), (ImageSpec{Pixel::count16, 0, width, 32}));
  EXPECT_NEAR(depths->at<int16_t>(near_px, 240), 120, 8) << "as high as the box";
  EXPECT_NEAR(depths->at<int16_t>(far_px, 240), height - 120 - 8, 8);
  EXPECT_NEAR(depths->at<int16_t>(far_px, 100), height - 8, 8);
  EXPECT_EQ(depths->at<int16_t>(0, 100), 0);
  for (int d = 0; d < 32; ++d) {
    for (int column = 0; column < width; ++column) {
      int count = 0;
      for (int row = 0; row < height; ++row) {
        const int16_t pixel = found->at<int16_t>(row, column);
        count += pixel > 0 && pixel / 16 == d;
      }
      ASSERT_EQ(depths->at<int16_t>(d, column), count) << d << " " << column;
    }
  }
}

/// A model that takes what is near (row 35 of 60 on: 19 px of 32) for an obstacle, and evades from the half of the picture it is in.
struct ClassifyTest : SecondDetectorTest {
  const TemporaryFolder folder;
  snow::ModelParts parts;
  std::vector<float> free = std::vector<float>(snow::vector_length, 0.001f), obstacle = free, to_left = free, to_right = free;

  ClassifyTest() {
    for (int x = 0; x < snow::columns; ++x)
      for (int y = 35; y < snow::rows; ++y)
        for (int value = 128; value < 256; ++value) {
          obstacle[snow::feature_id(x, y, value)] += 1;
          (x < snow::columns / 2 ? to_right : to_left)[snow::feature_id(x, y, value)] += 1;
        }
    parts.settings = front_end(config, left.spec());
    parts.obstacle.winnow.theta = parts.direction.winnow.theta = 10;
    parts.obstacle.sensitivity = 0.25;
    parts.obstacle.clear = 2;
    parts.free = free;
    parts.obstacles = obstacle;
    parts.left = to_left;
    parts.right = to_right;
    config.snow.model = (folder / "model.snow").string();
  }
  std::unique_ptr<Picture> features() {
    const auto found = disparity();
    const auto depths = run(DepthMap(machine, config), {found.get()});
    return run(Features(config), {found.get(), depths.get()});
  }
  SnowScores classify() {
    const auto seen = features();
    const auto scores = run(Classify(config), {seen.get(), &left});
    return *record_of<SnowScores>(scores->image());
  }
};

TEST_F(ClassifyTest, a_box_is_an_obstacle_and_evaded_to_the_other_side) {
  snow::write_model(config.snow.model, parts);
  const SnowScores s = classify();
  // 20 of 80 columns hold the box, and half a window at its edges; row floor(60 * 21 / 32) = 39, sums of four columns near 4 * 120.
  EXPECT_NEAR(s.obstacle - s.free, 21, 1.5);
  EXPECT_NEAR(s.free_difference, -2.1, 0.15) << "over the threshold";
  EXPECT_NEAR(s.left_difference, 2.1, 0.15) << "the box is in the right half";
  EXPECT_EQ(s.active, 4800u);
  EXPECT_EQ(s.obstacle_sensitivity, 0.25) << "the model's";
  const Way way = way_of(s);
  EXPECT_FALSE(way.free);
  EXPECT_TRUE(way.left);
  EXPECT_EQ(way.clearness, 0);
  config.snow.obstacleSensitivity = 3;
  const Way other = way_of(classify());
  EXPECT_TRUE(other.free);
  EXPECT_NEAR(other.clearness, 0.9 / 2, 0.08) << "of what the model calls clear";
  config.snow.clear = 0.5;
  EXPECT_NEAR(way_of(classify()).clearness, 0.9, 0.15);
}

TEST_F(ClassifyTest, a_model_of_another_front_end_is_refused_by_what_differs) {
  parts.settings.block = 7;
  parts.settings.encoding = snow::Encoding::contour;
  snow::write_model(config.snow.model, parts);
  const auto seen = features();
  try {
    run(Classify(config), {seen.get(), &left});
    FAIL();
  } catch (const snow::ModelError& error) {
    EXPECT_EQ(error.exit_code, 78);
    EXPECT_NE(std::string(error.what()).find("block"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("contour"), std::string::npos) << error.what();
  }
}

TEST_F(ClassifyTest, takes_nothing_from_the_heap) {
  snow::write_model(config.snow.model, parts);
  Machine one(1);
  SmoothedView smooth(one, config);
  CensusView encode(one);
  CensusDisparity match(one, config);
  DepthMap depth(one, config);
  Features describe(config);
  Classify judge(config);
  Picture sl(smooth.accept(left.spec())), sr(smooth.accept(left.spec())), cl(encode.accept(sl.spec())), cr(encode.accept(sl.spec()));
  Picture d(match.check(std::vector{cl.spec(), cr.spec(), sl.spec()})[0]), u(depth.accept(d.spec())),
      f(describe.accept(d.spec(), u.spec()));
  Picture s(judge.check(std::vector{f.spec(), sl.spec()})[0]);
  const auto frame = [&] {
    smooth.filter(left.image(), sl.image());
    smooth.filter(right.image(), sr.image());
    encode.filter(sl.image(), cl.image());
    encode.filter(sr.image(), cr.image());
    const Image *const views[] = {&cl.image(), &cr.image(), &sl.image()}, *const seen[] = {&f.image(), &sl.image()};
    Image *const matched[] = {&d.image()}, *const judged[] = {&s.image()};
    match.process(views, matched);
    depth.filter(d.image(), u.image());
    describe.combine(d.image(), u.image(), f.image());
    judge.process(seen, judged);
  };
  frame();
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 10; ++i) frame();
  EXPECT_EQ(allocations_of_this_thread(), before);
  EXPECT_GT(record_of<SnowScores>(s.image())->obstacle, 10);
}

}  // namespace
}  // namespace vdisp
