// disparity_test.cpp: rectification and both matchers on images whose disparity is known by construction.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/disparity.h"

#include <gtest/gtest.h>

#include <random>

#include "daemon/stages/rectify.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int width = 200, height = 80;

struct DisparityTest : testing::TestWithParam<const char*> {
  Machine machine;
  Config config;
  Picture left{Pixel::gray8, width, height}, right{Pixel::gray8, width, height};
  std::vector<std::unique_ptr<Picture>> out;

  void SetUp() override { config.image_source.matcher = GetParam(); }
  // A random texture, seen by the right camera `shift` px further left.
  void shifted(int shift) {
    std::mt19937 random(3);
    std::vector<uint8_t> texture(static_cast<size_t>(height) * 512);
    for (uint8_t& pixel : texture) pixel = static_cast<uint8_t>(random());
    left.fill<uint8_t>([&](int v, int u) { return texture[static_cast<size_t>(v * 512 + u + 100)]; });
    right.fill<uint8_t>([&](int v, int u) { return texture[static_cast<size_t>(v * 512 + u + 100 + shift)]; });
  }
  Outcome match() {
    Disparity stage(machine, config);
    return run_stage(stage, {&left, &right}, out);
  }
  int16_t at(int v, int u) { return out.at(0)->at<int16_t>(v, u); }
  int count(Rejected why) {
    int n = 0;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) n += at(v, u) == rejected(why);
    return n;
  }
  int found() {
    int n = 0;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) n += rejected_code(at(v, u)) == 0;
    return n;
  }
};

TEST_P(DisparityTest, a_shift_of_7_px_is_112_sixteenths) {
  shifted(7);
  ASSERT_EQ(match(), Outcome::valid);
  for (int v = 10; v < height - 10; ++v)
    for (int u = 70; u < width - 20; ++u) ASSERT_NEAR(at(v, u), 112, 4) << v << ' ' << u;
}

TEST_P(DisparityTest, the_search_can_begin_above_zero) {
  config.image_source.minDisparity = 20;
  config.image_source.ndisp = 32;
  shifted(30);
  ASSERT_EQ(match(), Outcome::valid);
  ASSERT_NEAR(at(40, 120), 480, 1);
  EXPECT_EQ(out[0]->image().camera.min_disparity, 20);
  EXPECT_EQ(out[0]->image().camera.disparities, 32);
}

TEST_P(DisparityTest, what_the_search_cannot_reach_is_outside) {
  shifted(7);
  match();
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < 40; ++u) ASSERT_EQ(at(v, u), rejected(Rejected::outside)) << v << ' ' << u;
}

TEST_P(DisparityTest, every_pixel_has_a_disparity_in_range_or_a_reason) {
  shifted(7);
  right.fill<uint8_t>([&](int v, int u) { return v < 40 ? right.at<uint8_t>(v, u) : static_cast<uint8_t>(u * v); });
  match();
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const int16_t d = at(v, u);
      const bool reasoned = d <= rejected(Rejected::low_texture) && d >= rejected(Rejected::matcher);
      ASSERT_TRUE(reasoned || (d > -16 && d < 48 * 16)) << d;
    }
}

TEST_P(DisparityTest, small_areas_are_speckles) {
  shifted(7);
  // One patch of 20x20 pixels lies 20 px nearer.
  for (int v = 30; v < 50; ++v)
    for (int u = 100; u < 120; ++u) right.at<uint8_t>(v, u - 20) = left.at<uint8_t>(v, u);
  config.image_source.SpeckleSize = 0;
  match();
  EXPECT_EQ(count(Rejected::speckle), 0);
  const int before = found();
  config.image_source.SpeckleSize = 1000;
  match();
  EXPECT_GT(count(Rejected::speckle), 100);
  EXPECT_LT(found(), before);
}

TEST_P(DisparityTest, narrow_images_are_refused_while_building) {
  config.image_source.ndisp = 256;
  try {
    match();
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(),
                 "the images are 200 columns wide, ndisp + minDisparity + corrsize = 267 leaves none to search; a smaller ndisp would fit");
  }
}

TEST_P(DisparityTest, images_of_two_sizes_are_refused) {
  Disparity stage(machine, config);
  EXPECT_THROW(stage.check(std::array{left.spec(), ImageSpec{Pixel::gray8, 0, 100, 80}}), FormatError);
  EXPECT_THROW(stage.check(std::array{left.spec(), ImageSpec{Pixel::disparity16, 0, width, height}}), FormatError);
  EXPECT_THROW(stage.check(std::array{left.spec(), left.spec(), left.spec()}), FormatError);
}

INSTANTIATE_TEST_SUITE_P(Matchers, DisparityTest, testing::Values("bm", "opencv", "opencv-sgbm"), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

struct BlockMatchingTest : DisparityTest {};

TEST_P(BlockMatchingTest, a_blank_image_has_no_texture) {
  left.fill<uint8_t>([](int, int) { return 128; });
  right.fill<uint8_t>([](int, int) { return 128; });
  match();
  EXPECT_EQ(found(), 0);
  EXPECT_EQ(at(40, 100), rejected(Rejected::low_texture));
}

TEST_P(BlockMatchingTest, a_higher_thresh_rejects_more_for_texture) {
  std::mt19937 random(1);
  shifted(7);
  for (Picture* view : {&left, &right})
    view->fill<uint8_t>([&](int v, int u) { return static_cast<uint8_t>(120 + view->at<uint8_t>(v, u) / 100 + random() % 2); });
  int last = -1;
  for (int thresh : {0, 10, 20, 40}) {
    config.image_source.thresh = thresh;
    match();
    EXPECT_GE(count(Rejected::low_texture), last);
    last = count(Rejected::low_texture);
  }
  EXPECT_GT(last, 1000);
}

INSTANTIATE_TEST_SUITE_P(Matchers, BlockMatchingTest, testing::Values("bm", "opencv"));

TEST(Rectify, without_calibration_the_image_passes_unchanged) {
  Machine machine;
  Config config;
  Picture in(Pixel::gray8, 33, 5);
  in.fill<uint8_t>([](int v, int u) { return static_cast<uint8_t>(7 * v + u); });
  std::vector<std::unique_ptr<Picture>> out;
  Rectify stage(Side::left, std::nullopt, machine, config);
  ASSERT_EQ(run_stage(stage, {&in}, out), Outcome::valid);
  EXPECT_EQ(out[0]->at<uint8_t>(4, 32), 60);
  EXPECT_EQ(out[0]->image().camera.f, 0);
}

TEST(Rectify, a_mosaic_is_grey_before_it_is_rectified) {
  const std::array colours{200.0, 120.0, 40.0};  // red, green, blue
  Calibration same;
  RawCamera camera;
  camera.k = camera.rectification = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  camera.projection = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  same.raw = {camera, camera};
  const std::vector<std::pair<std::string, std::array<size_t, 4>>> patterns{
      {"rggb", {0, 1, 1, 2}}, {"bggr", {2, 1, 1, 0}}, {"grbg", {1, 0, 2, 1}}, {"gbrg", {1, 2, 0, 1}}};
  for (const auto& [word, colour] : patterns) {
    for (const auto& calibration : {std::optional<Calibration>(), std::optional<Calibration>(same)}) {
      Config config;
      config.image_source.bayer = word;
      Picture in(Pixel::gray8, 70, 20);
      in.fill<uint8_t>([&](int v, int u) { return static_cast<uint8_t>(colours[colour[static_cast<size_t>(v % 2 * 2 + u % 2)]]); });
      std::vector<std::unique_ptr<Picture>> out;
      Machine machine;
      Rectify stage(Side::left, calibration, machine, config);
      ASSERT_EQ(run_stage(stage, {&in}, out), Outcome::valid);
      for (int v = 0; v < 20; ++v)
        for (int u = 0; u < 70; ++u)
          ASSERT_NEAR(out[0]->at<uint8_t>(v, u), 0.299 * 200 + 0.587 * 120 + 0.114 * 40, 1) << word << v << ' ' << u;
    }
  }
}

TEST(Rectify, another_size_than_the_calibrations_or_the_configured_is_refused) {
  Machine machine;
  Config config;
  Calibration calibration;
  calibration.width = 320;
  calibration.height = 240;
  calibration.format = "OpenCV";
  try {
    Rectify(Side::left, calibration, machine, config).accept({Pixel::gray8, 0, 640, 480});
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "the images are 640x480, the calibration (OpenCV) is for 320x240");
  }
  config.image_source.width = 640;
  config.image_source.height = 480;
  EXPECT_THROW(Rectify(Side::left, std::nullopt, machine, config).accept({Pixel::gray8, 0, 320, 240}), FormatError);
}

TEST(Rectify, a_camera_turned_by_rectification_sees_the_world_moved) {
  // A rotation about Y by alpha moves what is at the centre by f tan(alpha).
  Machine machine;
  Config config;
  Calibration calibration;
  const double f = 200, alpha = 0.05;
  RawCamera camera;
  camera.k = {f, 0, 100, 0, f, 50, 0, 0, 1};
  camera.rectification = {std::cos(alpha), 0, std::sin(alpha), 0, 1, 0, -std::sin(alpha), 0, std::cos(alpha)};
  camera.projection = {f, 0, 100, 0, 0, f, 50, 0, 0, 0, 1, 0};
  calibration.raw = {camera, camera};
  calibration.view = {f, 100, 50, 0.1, 0};
  Picture in(Pixel::gray8, 200, 100);
  in.fill<uint8_t>([](int, int u) { return static_cast<uint8_t>(u); });
  std::vector<std::unique_ptr<Picture>> out;
  Rectify stage(Side::right, calibration, machine, config);
  ASSERT_EQ(run_stage(stage, {&in}, out), Outcome::valid);
  EXPECT_NEAR(out[0]->at<uint8_t>(50, 110), 100, 1);  // rectified (x, z) = R (0, 1): x / z = tan(alpha), 10 px to the right
  EXPECT_FLOAT_EQ(out[0]->image().camera.f, 200);
}

}  // namespace
}  // namespace vdisp
