// rising_ground_test.cpp: ground beside the way that rises gently is floor, and what stands, or may, is none.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <tuple>
#include <vector>

#include "daemon/geometry/floor_plane.h"
#include "daemon/stages/surfaces.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int width = 640, height = 480;
constexpr double high = 0.8;       // m
constexpr double bar_ahead = 3.0;  // m
const StereoView view{500, 320, 240, 0.1, 0};
constexpr double wall = 0.02;  // m along the way that what stands upright needs to rise

/// How high the ground is, m, `ahead` and to the right, m.
using Ground = std::function<double(double ahead, double right)>;

double meets(const Ground& ground, const Point& h) {
  const auto above = [&](double t) { return high - h.y * t - ground(h.z * t, h.x * t); };
  double before = 0.4;
  for (double t = before; t < 8; t += 0.04) {
    if (above(t) > 0) {
      before = t;
      continue;
    }
    double behind = t;
    for (int i = 0; i < 9; ++i) (above((before + behind) / 2) > 0 ? before : behind) = (before + behind) / 2;
    return behind;
  }
  return 0;
}

struct RisingGroundTest : testing::Test {
  Config config;
  Machine machine;
  Picture disparity{Pixel::disparity16, width, height}, left{Pixel::gray8, width, height}, floor{record_spec<FloorModel>()};
  std::vector<std::unique_ptr<Picture>> out;
  std::vector<Point> places = std::vector<Point>(width * height);  // to the right, up, ahead, m; ahead = 0: nothing
  double noise = 0, pitch = 0.2;                                   // px, rad

  void SetUp() override { config.limit.max_height = 0.1f; }
  /// The floor that is told is level. `matched`: of a place, to the right, up, ahead; `hangs`: of a place bar_ahead m ahead, whether
  /// something hangs there before the ground.
  void look(const Ground& ground, const std::function<bool(const Point&)>& matched = {},
            const std::function<bool(const Point&)>& hangs = {}) {
    std::mt19937 random(1);
    std::normal_distribution<double> error(0, 1);
    disparity.image().camera = {500, 320, 240, 0.1f, 0, 0, config.image_source.ndisp, {}};
    disparity.fill<int16_t>([&](int v, int u) {
      const Point h = horizontal({(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, pitch);
      const double t = meets(ground, h);
      Point& place = places[static_cast<size_t>(v * width + u)];
      place = {h.x * t, high - h.y * t, h.z * t};
      const double bar = bar_ahead / h.z;
      const Point on_bar{h.x * bar, high - h.y * bar, bar_ahead};
      const bool is_bar = hangs && hangs(on_bar) && (t == 0 || bar < t);
      if (is_bar) place = on_bar;
      if (place.z == 0 || (matched && !matched(place))) return rejected(Rejected::low_texture);
      return static_cast<int16_t>(std::lround(16 * (view.disparity(is_bar ? bar : t) + noise * error(random))));
    });
    left.fill<uint8_t>([](int v, int u) { return static_cast<uint8_t>(60 + (u * 7919 + v * 104729) % 97); });
    const FloorPlane plane = plane_of({pitch, 0, high}, view);
    FloorModel& model = make_record<FloorModel>(floor.image());
    model.state = FloorState::found;
    model.model = FloorKind::plane;
    model.a = 1 / (16 * plane.down);
    model.b = view.cy - plane.middle / plane.down;
    model.pitch_rad = pitch;
    model.height_m = high;
    Surfaces surfaces(machine, config);
    ASSERT_EQ(run_stage(surfaces, {&disparity, &floor, &left}, out), Outcome::valid);
  }
  /// Of the pixels that show such places, and that are higher than max_height: how many, and which share of them is floor.
  std::pair<int, double> floor_of(const std::function<bool(const Point&)>& there) {
    int all = 0, is_floor = 0;
    for (int v = 0; v < height; ++v) {
      for (int u = config.image_source.ndisp; u < width; ++u) {
        const Point& place = places[static_cast<size_t>(v * width + u)];
        if (place.z == 0 || out[0]->at<int16_t>(v, u) == height_unknown || place.y < config.limit.max_height + 0.03 || !there(place))
          continue;
        ++all;
        is_floor += static_cast<Surface>(out[1]->at<uint8_t>(v, u)) == Surface::floor;
        // Only what is an obstacle has a disparity among the obstacles.
        EXPECT_EQ(out[2]->at<int16_t>(v, u) > rejected_base, static_cast<Surface>(out[1]->at<uint8_t>(v, u)) == Surface::obstacle);
      }
    }
    return {all, all > 0 ? static_cast<double>(is_floor) / all : 0};
  }
};

/// Rises along the way, from 1 m on, at the right side only.
Ground bank(double degrees) {
  return [=](double ahead, double right) { return right > 0.3 ? std::tan(degrees * M_PI / 180) * std::max(ahead - 1, 0.0) : 0.0; };
}
Ground step(double from, double tall) {
  return [=](double ahead, double) { return tall * std::clamp((ahead - from) / wall, 0.0, 1.0); };
}
/// Where it is seen to begin, and not from the side.
bool on_bank(const Point& place) { return place.x > 0.33 * place.z && place.z < 3.8; }

TEST_F(RisingGroundTest, a_bank_beside_the_way_that_rises_gently_is_floor) {
  for (const auto& [degrees, px, least] : {std::tuple{8.0, 0.0, 0.98}, {4.0, 0.2, 0.95}, {8.0, 0.2, 0.75}}) {
    noise = px;
    look(bank(degrees));
    const auto [all, share] = floor_of(on_bank);
    EXPECT_GT(all, 5000) << degrees;
    EXPECT_GT(share, least) << degrees << " deg, noise " << px;
  }
}

TEST_F(RisingGroundTest, a_bank_steeper_than_maxSlope_is_an_obstacle) {
  for (const auto& [degrees, steepest] : {std::pair{25.0, 0.35f}, {8.0, 0.1f}}) {
    config.floor.maxSlope = steepest;
    look(bank(degrees));
    const auto [all, share] = floor_of(on_bank);
    EXPECT_GT(all, 5000) << degrees;
    EXPECT_LT(share, 0.02) << degrees;
  }
}

TEST_F(RisingGroundTest, the_face_and_the_top_of_a_step_are_obstacles) {
  for (const auto& [tall, from, px] : {std::tuple{0.2, 1.5, 0.2}, {0.3, 1.5, 0.0}, {0.2, 3.5, 0.2}, {0.3, 3.5, 0.2}}) {
    noise = px;
    look(step(from, tall));
    const auto [all, share] = floor_of([](const Point& place) { return place.z < 6; });
    EXPECT_GT(all, 1000) << tall << ' ' << from;
    EXPECT_LT(share, 0.02) << tall << " m high, from " << from << " m, noise " << px;
  }
}

TEST_F(RisingGroundTest, the_top_behind_a_face_that_is_not_matched_is_an_obstacle) {
  for (const double from : {1.5, 3.5}) {
    look(step(from, 0.25), [&](const Point& place) { return std::abs(place.z - from) > 0.05; });
    const auto [all, share] = floor_of([&](const Point& place) { return place.z > from && place.z < 6; });
    EXPECT_GT(all, 1000) << from;
    EXPECT_LT(share, 0.02) << from;
  }
}

TEST_F(RisingGroundTest, what_stands_behind_a_brow_is_an_obstacle) {
  // The bank ends in a brow, behind which the ground falls as steeply again. Nothing of the foot of the wall is seen.
  look([](double ahead, double) {
    const double behind = 0.15 * std::clamp(ahead - 1, 0.0, 1.0) - 0.35 * std::max(ahead - 2, 0.0);
    return behind + (ahead > 3.2 ? 1.0 * std::clamp((ahead - 3.2) / wall, 0.0, 1.0) : 0);
  });
  const auto [all, share] = floor_of([](const Point& place) { return place.z > 3 && place.z < 3.3; });
  EXPECT_GT(all, 1000);
  EXPECT_LT(share, 0.02);
}

// The foot of the wall is hidden: of what is seen first of it, nothing is ground, however near behind the brow it is.
TEST_F(RisingGroundTest, the_lowest_part_of_a_wall_seen_over_a_brow_is_an_obstacle) {
  config.limit.max_height = 0.2f;
  noise = 0.1;
  for (const double brow : {3.0, 4.0}) {
    for (const double behind : {0.9, 1.2}) {
      look([=](double ahead, double) {
        const double bank = 0.3 * std::clamp((ahead - 1) / (brow - 1), 0.0, 1.0) - 0.5 * std::max(ahead - brow, 0.0);
        return bank + 1.5 * std::clamp((ahead - brow - behind) / wall, 0.0, 1.0);
      });
      const auto [all, share] = floor_of([&](const Point& place) { return place.z > brow + behind - 0.05; });
      EXPECT_GT(all, 1000) << brow << ' ' << behind;
      EXPECT_LT(share, 0.01) << brow << ' ' << behind;
    }
  }
}

TEST_F(RisingGroundTest, the_top_of_a_step_hardly_higher_than_max_height_is_an_obstacle_as_far_off_as_ground_is_told) {
  config.limit.max_height = 0.15f;  // 12 rows at 6.2 m
  noise = 0.1;
  for (const float steepest : {0.35f, 0.7f}) {
    config.floor.maxSlope = steepest;
    look(step(5.2, 0.19));
    const auto [all, share] = floor_of([](const Point& place) { return place.z > 5.15 && place.z < 7; });
    EXPECT_GT(all, 1000) << steepest;
    EXPECT_LT(share, 0.02) << steepest;
  }
}

// 3 m off, 0.1 m thick, and the bank is seen below it and above.
TEST_F(RisingGroundTest, a_bar_before_a_bank_is_an_obstacle) {
  const double degrees = 8;
  for (const double from : {0.3, 0.35, 0.4}) {
    noise = 0.1;
    look([=](double ahead, double) { return std::tan(degrees * M_PI / 180) * std::max(ahead - 1.5, 0.0); }, {},
         [=](const Point& at_3_m) { return at_3_m.y > from && at_3_m.y < from + 0.1 && std::abs(at_3_m.x) < 0.7; });
    const auto [all, share] = floor_of([&](const Point& place) { return place.z == bar_ahead && std::abs(place.x) < 0.6; });
    EXPECT_GT(all, 3000) << from;
    EXPECT_LT(share, 0.02) << from;
  }
}

TEST_F(RisingGroundTest, a_box_whose_foot_is_below_the_picture_is_an_obstacle) {
  for (const auto& [tilt, from] : {std::pair{0.0, 1.35}, {-0.05, 1.5}, {-0.1, 1.8}}) {
    pitch = tilt;
    config.limit.max_height = 0.2f;
    look(step(from, 0.3));
    const auto [all, share] = floor_of([&](const Point& place) { return place.z < from + 0.1; });
    EXPECT_GT(all, 1000) << from;
    EXPECT_LT(share, 0.02) << from;
  }
}

// The object, 0.3 m high and wide: what is seen of it over max_height, less half a window at its rims.
TEST_F(RisingGroundTest, the_foot_of_what_stands_on_the_bank_is_an_obstacle) {
  config.limit.max_height = 0.2f;
  noise = 0.1;
  for (const double degrees : {4.0, 8.0}) {
    const double slope = std::tan(degrees * M_PI / 180);
    look([&](double ahead, double right) {
      const bool box = std::abs(right) < 0.15 && ahead > 4;
      return slope * std::max(ahead - 1, 0.0) + (box ? 0.3 * std::clamp((ahead - 4) / wall, 0.0, 1.0) : 0);
    });
    const auto [all, share] = floor_of([&](const Point& place) { return std::abs(place.x) < 0.13 && place.z > 3.99 && place.z < 4.1; });
    EXPECT_GT(all, 500) << degrees;
    EXPECT_LT(share, 0.25) << degrees;
  }
}

// The nearest disparities there are: a bank of which the table of distances hardly goes on.
TEST_F(RisingGroundTest, what_is_as_near_as_can_be_matched_is_an_obstacle) {
  config.image_source.ndisp = 32;
  config.limit.max_height = 0.2f;
  look(step(1.65, 0.3), [&](const Point& place) { return place.z > 1.6; });
  const auto [all, share] = floor_of([](const Point& place) { return place.z < 1.7; });
  EXPECT_GT(all, 1000);
  EXPECT_LT(share, 0.02);
}

TEST_F(RisingGroundTest, it_is_only_told_as_far_off_as_a_step_would_be_seen) {
  // A step of max_height, 0.1 m, is 12 rows high 500 * 0.1 / 12 = 4.2 m off.
  look(bank(4));
  const auto between = [&](double from, double to) {
    return floor_of([=](const Point& place) { return place.x > 0.33 * place.z && place.z > from && place.z < to; });
  };
  EXPECT_GT(between(3.5, 4).first, 1000);
  EXPECT_GT(between(3.5, 4).second, 0.9);
  EXPECT_GT(between(4.8, 6).first, 1000);
  EXPECT_LT(between(4.8, 6).second, 0.1);
}

TEST_F(RisingGroundTest, what_stands_on_the_bank_is_an_obstacle) {
  const Ground gentle = bank(6);
  look([&](double ahead, double right) {
    const bool box = right > 0.8 && right < 1.2 && ahead > 3 && ahead < 3.3;
    return gentle(ahead, right) + (box ? 0.4 * std::clamp((ahead - 3) / wall, 0.0, 1.0) : 0);
  });
  const auto [all, share] = floor_of([](const Point& place) {
    const double over = place.y - std::tan(6 * M_PI / 180) * (place.z - 1);
    return place.x > 0.82 && place.x < 1.18 && place.z > 2.95 && place.z < 3.1 && over > 0.14;
  });
  EXPECT_GT(all, 500);
  EXPECT_LT(share, 0.05);
}

}  // namespace
}  // namespace vdisp
