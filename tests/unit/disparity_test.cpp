// disparity_test.cpp: rectification and both matchers on images whose disparity is known by construction.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/disparity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
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

TEST_P(DisparityTest, images_narrower_than_a_search_below_zero_are_refused_while_building) {
  config.image_source.ndisp = 16;
  config.image_source.minDisparity = -128;
  config.image_source.corrsize = 21;
  Disparity stage(machine, config);
  const auto check = [&](uint16_t columns) {
    const ImageSpec view{Pixel::gray8, 0, columns, 80};
    stage.check(std::array{view, view});
  };
  try {
    check(140);
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(),
                 "the images are 140 columns wide, minDisparity = -128 with corrsize = 21 leaves none to search; minDisparity from -118 on "
                 "would fit");
  }
  EXPECT_NO_THROW(check(150));
  config.image_source.minDisparity = -118;
  EXPECT_NO_THROW(check(140));
}

TEST_P(DisparityTest, images_of_two_sizes_are_refused) {
  Disparity stage(machine, config);
  EXPECT_THROW(stage.check(std::array{left.spec(), ImageSpec{Pixel::gray8, 0, 100, 80}}), FormatError);
  EXPECT_THROW(stage.check(std::array{left.spec(), ImageSpec{Pixel::disparity16, 0, width, height}}), FormatError);
  EXPECT_THROW(stage.check(std::array{left.spec(), left.spec(), left.spec()}), FormatError);
}

TEST_P(DisparityTest, smoothed_views_are_matched_as_well) {
  shifted(7);
  match();
  const int as_they_are = found();
  for (const char* word : {"mean", "median"}) {
    config.image_source.smooth = word;
    ASSERT_EQ(match(), Outcome::valid);
    EXPECT_GT(found(), as_they_are * 0.9) << word;
    for (int v = 10; v < height - 10; ++v)
      for (int u = 70; u < width - 20; ++u) ASSERT_NEAR(at(v, u), 112, 4) << word << v << ' ' << u;
  }
}

INSTANTIATE_TEST_SUITE_P(Matchers, DisparityTest, testing::Values("bm", "census", "sgm", "opencv", "opencv-sgbm"), [](const auto& test) {
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

INSTANTIATE_TEST_SUITE_P(Matchers, BlockMatchingTest, testing::Values("bm", "census", "opencv"));

/// What block matching compares: key and word.
struct Codes {
  const char *matcher, *prefilter, *census;
};

struct MatchedViewsTest : testing::TestWithParam<Codes> {
  Config config;
  MatchedViewsTest() {
    config.image_source.matcher = GetParam().matcher;
    config.image_source.prefilter = GetParam().prefilter;
    config.image_source.census = GetParam().census;
  }
};

/// A textured floor under a camera 0.4 m high, 0.1 rad down, f = 400 px, B = 0.1 m: 1/4 px of disparity a row, the truth by arithmetic.
struct FlatFloor {
  static constexpr int width = 320, height = 240;
  static constexpr double f = 400, baseline = 0.1, up = 0.4, pitch = 0.1, cx = 160, cy = 120;
  static constexpr double disparity(int v) { return baseline / up * (std::sin(pitch) * f + std::cos(pitch) * (v - cy)); }
  Picture left{Pixel::gray8, width, height}, right{Pixel::gray8, width, height};

  /// Each row has a texture of its own, smooth over `grain` px; the left camera sees it `disparity` further right.
  explicit FlatFloor(double gain = 1) {
    std::mt19937 random(8);
    for (int v = 0; v < height; ++v) {
      std::array<double, 256> texture;
      for (double& value : texture) value = 60 + static_cast<double>(random() % 120);
      const auto at = [&](double x) {
        const double place = x / 2 + 40, part = place - std::floor(place);
        const auto i = static_cast<size_t>(place);
        return texture[i] * (1 - part) + texture[i + 1] * part;
      };
      for (int u = 0; u < width; ++u) {
        right.at<uint8_t>(v, u) = static_cast<uint8_t>(gain * at(u));
        left.at<uint8_t>(v, u) = static_cast<uint8_t>(at(u - disparity(v)));
      }
    }
    for (Picture* view : {&left, &right})
      view->image().camera = {
          static_cast<float>(f), static_cast<float>(cx), static_cast<float>(cy), static_cast<float>(baseline), 0, 0, 0, {}};
  }
};

/// Share of the lower third with a disparity, and of these within 1 px of the truth.
std::pair<double, double> floor_found(Picture& disparity) {
  int all = 0, found = 0, right = 0;
  for (int v = FlatFloor::height * 2 / 3; v < FlatFloor::height - 10; ++v) {
    for (int u = 70; u < FlatFloor::width - 20; ++u) {
      const int16_t d = disparity.at<int16_t>(v, u);
      ++all;
      if (rejected_code(d) != 0) continue;
      ++found;
      right += std::abs(d / 16.0 - FlatFloor::disparity(v)) <= 1;
    }
  }
  return {static_cast<double>(found) / all, static_cast<double>(right) / std::max(found, 1)};
}

TEST_P(MatchedViewsTest, a_slanted_floor_is_found_where_it_is_expected) {
  FlatFloor floor;
  config.mounting.height = static_cast<float>(FlatFloor::up);
  config.mounting.pitch = static_cast<float>(FlatFloor::pitch);
  std::vector<std::unique_ptr<Picture>> out;
  Machine machine;
  std::array<double, 2> share;
  for (const char* align : {"none", "floor"}) {
    config.image_source.align = align;
    Disparity stage(machine, config);
    ASSERT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
    const auto [found, right] = floor_found(*out[0]);
    share[align[0] == 'f'] = found;
    EXPECT_GT(right, 0.98) << align;
  }
  EXPECT_GT(share[1], 0.9);
  EXPECT_GE(share[1], share[0]);
}

TEST_P(MatchedViewsTest, a_floor_too_near_for_the_search_is_no_obstacle) {
  FlatFloor floor;
  config.mounting.height = static_cast<float>(FlatFloor::up);
  config.mounting.pitch = static_cast<float>(FlatFloor::pitch);
  config.image_source.ndisp = 16;
  Machine machine;
  Disparity stage(machine, config);
  std::vector<std::unique_ptr<Picture>> out;
  ASSERT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
  int claimed = 0;
  for (int v = 160; v < FlatFloor::height; ++v) {  // 20 px and more
    ASSERT_GT(FlatFloor::disparity(v), 19);
    for (int u = 0; u < FlatFloor::width; ++u) claimed += rejected_code(out[0]->at<int16_t>(v, u)) == 0;
  }
  EXPECT_LT(claimed, FlatFloor::width * 80 / 100) << "one in a hundred pixels whose match is not in the search";
}

/// Beside the last columns of the floor's search, where the right view ends, only the floor itself is believed.
TEST_P(MatchedViewsTest, at_the_right_border_nothing_is_claimed_off_the_floor) {
  FlatFloor floor;
  config.mounting.height = static_cast<float>(FlatFloor::up);
  config.mounting.pitch = static_cast<float>(FlatFloor::pitch);
  Machine machine;
  Disparity stage(machine, config);
  std::vector<std::unique_ptr<Picture>> out;
  ASSERT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
  for (int v = 90; v < FlatFloor::height; ++v) {
    for (int u = FlatFloor::width - 16; u < FlatFloor::width; ++u) {
      const int16_t d = out[0]->at<int16_t>(v, u);
      if (rejected_code(d) == 0) {
        EXPECT_NEAR(d / 16.0, FlatFloor::disparity(v), 1.6) << v << ' ' << u;
      }
    }
  }
}

TEST_P(MatchedViewsTest, threads_and_instruction_sets_change_nothing) {
  FlatFloor floor(0.9);
  config.mounting.height = static_cast<float>(FlatFloor::up);
  config.mounting.pitch = static_cast<float>(FlatFloor::pitch);
  for (const char* smooth : {"none", "median"}) {
    config.image_source.smooth = smooth;
    std::vector<std::unique_ptr<Picture>> expected, out;
    Machine plain(1, "plain");
    Disparity stage(plain, config);
    ASSERT_EQ(run_stage(stage, {&floor.left, &floor.right}, expected), Outcome::valid);
    for (const std::string& level : kernels::levels()) {
      Machine machine(3, level);
      Disparity other(machine, config);
      ASSERT_EQ(run_stage(other, {&floor.left, &floor.right}, out), Outcome::valid);
      for (int v = 0; v < FlatFloor::height; ++v)
        ASSERT_EQ(std::memcmp(out[0]->image().row<int16_t>(v), expected[0]->image().row<int16_t>(v), 2 * FlatFloor::width), 0)
            << level << smooth << v;
    }
  }
}

TEST_P(MatchedViewsTest, no_frame_depends_on_those_before_it) {
  FlatFloor floor;
  Picture noise(Pixel::gray8, FlatFloor::width, FlatFloor::height), model(record_spec<FloorModel>());
  std::mt19937 random(4);
  noise.fill<uint8_t>([&](int, int) { return static_cast<uint8_t>(random()); });
  noise.image().camera = floor.left.image().camera;
  const auto expect_floor_from = [&](double row) {
    auto& record = make_record<FloorModel>(model.image());
    record.state = FloorState::found;
    record.a = 1 / (16 * (FlatFloor::disparity(1) - FlatFloor::disparity(0)));
    record.b = row;
  };
  const double horizon = FlatFloor::cy - std::tan(FlatFloor::pitch) * FlatFloor::f;
  Machine machine;
  std::vector<std::unique_ptr<Picture>> alone, after;
  expect_floor_from(horizon);
  Disparity fresh(machine, config), used(machine, config);
  ASSERT_EQ(run_stage(fresh, {&floor.left, &floor.right, &model}, alone), Outcome::valid);
  expect_floor_from(horizon - 40);
  ASSERT_EQ(run_stage(used, {&noise, &noise, &model}, after), Outcome::valid);
  expect_floor_from(horizon);
  const std::array<const Image*, 3> in{&floor.left.image(), &floor.right.image(), &model.image()};
  const std::array<Image*, 1> out{&after[0]->image()};
  ASSERT_EQ(used.process(in, out), Outcome::valid);
  for (int v = 0; v < FlatFloor::height; ++v)
    ASSERT_EQ(std::memcmp(after[0]->image().row<int16_t>(v), alone[0]->image().row<int16_t>(v), 2 * FlatFloor::width), 0) << v;
}

TEST_P(MatchedViewsTest, texture_means_the_same_whatever_is_matched) {
  FlatFloor floor;
  // Half of the view is blank.
  for (Picture* view : {&floor.left, &floor.right})
    for (int v = 0; v < 120; ++v) std::memset(view->image().row<uint8_t>(v), 128, FlatFloor::width);
  const auto blank = [&](const Config& c) {
    Machine machine;
    Disparity stage(machine, c);
    std::vector<std::unique_ptr<Picture>> out;
    run_stage(stage, {&floor.left, &floor.right}, out);
    std::vector<bool> at;
    for (int v = 0; v < FlatFloor::height; ++v)
      for (int u = 0; u < FlatFloor::width; ++u) at.push_back(out[0]->at<int16_t>(v, u) == rejected(Rejected::low_texture));
    return at;
  };
  Config sobel;
  const auto expected = blank(sobel);
  EXPECT_EQ(blank(config), expected);
  EXPECT_GT(std::count(expected.begin(), expected.end(), true), 20000);
}

INSTANTIATE_TEST_SUITE_P(Codes, MatchedViewsTest,
                         testing::Values(Codes{"bm", "sobel", "3x3"}, Codes{"bm", "log", "3x3"}, Codes{"census", "sobel", "3x3"},
                                         Codes{"census", "sobel", "5x5"}),
                         [](const auto& test) {
                           const Codes& c = test.param;
                           return std::string(c.matcher) + "_" + (c.matcher[0] == 'b' ? c.prefilter : c.census);
                         });

TEST(Disparity, census_does_not_mind_how_bright_one_view_is) {
  FlatFloor dark(0.5);
  Machine machine;
  Config config;
  config.image_source.align = "none";
  std::array<double, 2> share;
  for (const char* matcher : {"bm", "census"}) {
    config.image_source.matcher = matcher;
    Disparity stage(machine, config);
    std::vector<std::unique_ptr<Picture>> out;
    run_stage(stage, {&dark.left, &dark.right}, out);
    share[matcher[0] == 'c'] = floor_found(*out[0]).first;
  }
  EXPECT_GT(share[1], 0.8);
  EXPECT_GT(share[1], share[0]);
}

std::string refusal(const Config& config) {
  Machine machine;
  try {
    const ImageSpec view{Pixel::gray8, 0, width, height};
    Disparity(machine, config).check(std::array{view, view});
    return "";
  } catch (const FormatError& error) {
    return error.what();
  }
}

TEST(Disparity, keys_of_another_matcher_are_refused_while_building) {
  Config config;
  config.image_source.prefilter = "log";
  EXPECT_EQ(refusal(config), "");
  for (const char* matcher : {"census", "opencv", "opencv-sgbm"}) {
    config.image_source.matcher = matcher;
    EXPECT_EQ(refusal(config), std::string("prefilter = log is for matcher = bm, and the matcher is ") + matcher +
                                   "; prefilter = sobel, or none in the file, would fit");
  }
  config = Config();
  config.image_source.census = "5x5";
  for (const char* matcher : {"bm", "opencv"}) {
    config.image_source.matcher = matcher;
    EXPECT_EQ(refusal(config), std::string("census = 5x5 is for matcher = census, and the matcher is ") + matcher +
                                   "; census = 3x3, or none in the file, would fit");
  }
  config.image_source.matcher = "census";
  EXPECT_EQ(refusal(config), "");
  config = Config();
  config.image_source.paths = "8";
  EXPECT_EQ(refusal(config), "paths = 8 is for matcher = sgm, and the matcher is bm; paths = 3, or none in the file, would fit");
  config.image_source.matcher = "sgm";
  EXPECT_EQ(refusal(config), "");
}

TEST(SemiGlobalMatcher, sees_a_slanted_floor_without_being_told_where_it_is) {
  FlatFloor floor;
  Machine machine;
  Config config;
  config.image_source.align = "none";
  const auto look = [&](const char* matcher, const char* paths) {
    config.image_source.matcher = matcher;
    config.image_source.paths = paths;
    std::vector<std::unique_ptr<Picture>> out;
    Disparity stage(machine, config);
    EXPECT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
    return floor_found(*out[0]);
  };
  const double windows = look("bm", "3").first;
  for (const char* paths : {"3", "4", "8"}) {
    const auto [found, right] = look("sgm", paths);
    EXPECT_GT(found, std::max(windows, 0.95)) << paths;
    EXPECT_GT(right, 0.98) << paths;
  }
}

/// Paths bring the disparity of the row above, which on a floor is smaller: nothing of that may be left in the sub-pixel part.
TEST(SemiGlobalMatcher, paths_do_not_lean_a_slanted_floor) {
  FlatFloor floor;
  Machine machine;
  Config config;
  config.image_source.matcher = "sgm";
  for (const char* paths : {"3", "4", "8"}) {
    config.image_source.paths = paths;
    std::vector<std::unique_ptr<Picture>> out;
    Disparity stage(machine, config);
    ASSERT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
    double sum = 0;
    int count = 0;
    for (int v = 100; v < FlatFloor::height - 10; ++v) {
      for (int u = 70; u < FlatFloor::width - 20; ++u) {
        const int16_t d = out[0]->at<int16_t>(v, u);
        const double error = d / 16.0 - FlatFloor::disparity(v);
        if (rejected_code(d) != 0 || std::abs(error) > 1) continue;
        sum += error;
        ++count;
      }
    }
    EXPECT_GT(count, 20000) << paths;
    EXPECT_NEAR(sum / count, 0, 0.03) << paths;
  }
}

/// Views that differ by noise have texture everywhere: what a higher thresh refuses then it refuses for the cost of the paths.
TEST(SemiGlobalMatcher, thresh_says_what_a_path_may_cost) {
  FlatFloor floor;
  std::mt19937 random(12);
  for (Picture* view : {&floor.left, &floor.right})
    view->fill<uint8_t>([&](int v, int u) { return static_cast<uint8_t>(view->at<uint8_t>(v, u) / 2 + random() % 60); });
  Machine machine;
  Config config;
  config.image_source.matcher = "sgm";
  config.image_source.unique = 0;
  const auto refused = [&](int thresh) {
    config.image_source.thresh = thresh;
    Disparity stage(machine, config);
    std::vector<std::unique_ptr<Picture>> out;
    EXPECT_EQ(run_stage(stage, {&floor.left, &floor.right}, out), Outcome::valid);
    int count = 0;
    for (int v = 0; v < FlatFloor::height; ++v) {
      for (int u = 0; u < FlatFloor::width; ++u) {
        const int16_t d = out[0]->at<int16_t>(v, u);
        EXPECT_NE(d, rejected(Rejected::low_texture)) << v << ' ' << u;
        count += d == rejected(Rejected::not_unique);
      }
    }
    return count;
  };
  EXPECT_LT(refused(0), 100);
  EXPECT_GT(refused(20), 5000);
}

TEST(SemiGlobalMatcher, claims_nothing_in_a_blank_image) {
  Machine machine;
  Config config;
  config.image_source.matcher = "sgm";
  Picture blank{Pixel::gray8, 200, 80};
  blank.fill<uint8_t>([](int, int) { return 128; });
  std::vector<std::unique_ptr<Picture>> out;
  Disparity stage(machine, config);
  ASSERT_EQ(run_stage(stage, {&blank, &blank}, out), Outcome::valid);
  for (int v = 0; v < 80; ++v)
    for (int u = 0; u < 200; ++u) ASSERT_LT(out[0]->at<int16_t>(v, u), rejected_base) << v << ' ' << u;
}

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
