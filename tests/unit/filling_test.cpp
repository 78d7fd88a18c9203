// filling_test.cpp: even surfaces between matched edges are obstacles where the left view shows one surface, and gaps stay gaps.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "daemon/geometry/floor_plane.h"
#include "daemon/stages/surfaces.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int width = 640, height = 480;
constexpr double high = 0.8, pitch = 0.2;  // m, rad
const StereoView view{500, 320, 240, 0.1, 0};

/// What a ray meets: how far along the view, its grey level, and whether it is matched.
struct Seen {
  double depth = 0;  // 0: nothing
  int grey = 220;
  bool matched = false;
};
using World = std::function<Seen(const Point& ray, int u, int v)>;

int rough(int u, int v) { return 60 + (u * 7919 + v * 104729) % 97; }

Seen floor_seen(const Point& ray, int u, int v) {
  const Point h = horizontal(ray, pitch);
  if (h.y <= 1e-3) return {};
  return {high / h.y, rough(u, v), true};
}

/// An upright rectangle: `ahead` m away, from x = left to right m and up to `tall` m.
struct Upright {
  double ahead, left, right, tall;
  bool meets(const Point& ray, double before) const {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, x = h.x * z, up = high - h.y * z;
    return x > left && x < right && up > 0 && up < tall && (before == 0 || z < before);
  }
  double depth(const Point& ray) const { return ahead / horizontal(ray, pitch).z; }
  /// px from the nearer of its sides.
  double inside(const Point& ray) const {
    const double x = horizontal(ray, pitch).x * depth(ray);
    return std::min(x - left, right - x) * view.f / ahead;
  }
};

/// Without texture: matched at its sides alone.
World with_blank(const World& world, const Upright& box) {
  return [=](const Point& ray, int u, int v) {
    const Seen behind = world(ray, u, v);
    return box.meets(ray, behind.depth) ? Seen{box.depth(ray), 150, box.inside(ray) < 6} : behind;
  };
}
World with_post(const World& world, double x, double ahead, double tall) {
  return [=](const Point& ray, int u, int v) {
    const Upright post{ahead, x - 0.05, x + 0.05, tall};
    const Seen behind = world(ray, u, v);
    return post.meets(ray, behind.depth) ? Seen{post.depth(ray), rough(u, v), true} : behind;
  };
}
World gate(const World& world) { return with_post(with_post(world, -0.4, 2.5, 1.1), 0.4, 2.5, 1.1); }

struct FillingTest : testing::Test {
  Config config;
  Machine machine;
  Picture disparity{Pixel::disparity16, width, height}, left{Pixel::gray8, width, height}, floor{record_spec<FloorModel>()};
  std::vector<std::unique_ptr<Picture>> out;
  std::vector<double> truth = std::vector<double>(width * height);

  void look(const World& world) {
    const auto ray = [](int v, int u) { return Point{(u - view.cx) / view.f, (v - view.cy) / view.f, 1}; };
    disparity.image().camera = {500, 320, 240, 0.1f, 0, 0, config.image_source.ndisp, {}};
    disparity.fill<int16_t>([&](int v, int u) {
      const Seen seen = world(ray(v, u), u, v);
      truth[static_cast<size_t>(v * width + u)] = seen.depth > 0 ? view.disparity(seen.depth) : 0;
      return seen.matched ? static_cast<int16_t>(std::lround(16 * view.disparity(seen.depth))) : rejected(Rejected::low_texture);
    });
    left.fill<uint8_t>([&](int v, int u) { return static_cast<uint8_t>(world(ray(v, u), u, v).grey); });
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
  Surface surface(int v, int u) { return static_cast<Surface>(out[1]->at<uint8_t>(v, u)); }
  int filled() {
    int count = 0;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) count += surface(v, u) == Surface::filled;
    return count;
  }
};

TEST_F(FillingTest, inside_of_a_blank_box_becomes_an_obstacle_at_the_distance_of_its_edges) {
  const Upright box{2.5, -0.4, 0.4, 0.6};
  look(with_blank(floor_seen, box));
  int inside = 0, right = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Point ray{(u - view.cx) / view.f, (v - view.cy) / view.f, 1};
      const double above = high - horizontal(ray, pitch).y * box.depth(ray);
      const bool blank = box.meets(ray, 0) && box.inside(ray) > 8 && above > config.limit.max_height + 0.02 && above < 0.56;
      const double is = out[2]->at<int16_t>(v, u) / 16.0, true_d = truth[static_cast<size_t>(v * width + u)];
      inside += blank;
      right += blank && surface(v, u) == Surface::filled && std::abs(is - true_d) < 0.3 &&
               std::abs(out[0]->at<int16_t>(v, u) / 1000.0 - above) < 0.03;
      // Filled is never floor, and nothing that was matched.
      if (surface(v, u) == Surface::filled) {
        ASSERT_LT(disparity.at<int16_t>(v, u), rejected_base);
        ASSERT_GT(out[0]->at<int16_t>(v, u), 1000 * config.limit.max_height);
      }
    }
  }
  EXPECT_GT(inside, 4000);
  EXPECT_GT(right, 0.9 * inside);
}

TEST_F(FillingTest, what_is_wider_than_told_is_left_alone) {
  const World box = with_blank(floor_seen, {2.5, -0.4, 0.4, 0.6});
  for (const auto& [most, fills] : {std::pair{0.0, false}, {0.7, false}, {0.9, true}}) {
    config.limit.fill = most;
    look(box);
    EXPECT_EQ(filled() > 0, fills) << most;
  }
}

TEST_F(FillingTest, posts_are_not_joined_whatever_lies_between_them) {
  const World blank_floor = [](const Point& ray, int u, int v) {
    Seen seen = floor_seen(ray, u, v);
    if (seen.depth > 0) seen = {seen.depth, 120, false};
    return seen;
  };
  const World near_floor_matched = [=](const Point& ray, int u, int v) { return v > 420 ? floor_seen(ray, u, v) : blank_floor(ray, u, v); };
  look(gate(floor_seen));
  EXPECT_EQ(filled(), 0) << "matched floor, sky";
  look(gate(blank_floor));
  EXPECT_EQ(filled(), 0) << "blank floor, sky";
  look(gate(near_floor_matched));
  EXPECT_EQ(filled(), 0) << "floor blank around the posts";
  look(gate(with_blank(floor_seen, {4, -3, 3, 0.9})));
  EXPECT_EQ(filled(), 0) << "a blank wall behind";
  look(gate(with_blank(floor_seen, {3, -0.8, 0.8, 0.8})));
  EXPECT_EQ(filled(), 0) << "a blank box close behind";
}

TEST_F(FillingTest, a_blank_patch_of_floor_is_neither_obstacle_nor_floor) {
  look([](const Point& ray, int u, int v) {
    const Seen seen = floor_seen(ray, u, v);
    return u > 250 && u < 400 && v > 260 && v < 330 ? Seen{seen.depth, 130, false} : seen;
  });
  EXPECT_EQ(filled(), 0);
  EXPECT_EQ(surface(300, 320), Surface::none);
}

TEST_F(FillingTest, an_edge_inside_ends_a_surface) {
  const World box = with_blank(floor_seen, {2.5, -0.4, 0.4, 0.6});
  look([=](const Point& ray, int u, int v) {
    Seen seen = box(ray, u, v);
    if (u > 320 && seen.grey == 150) seen.grey = 90;
    return seen;
  });
  EXPECT_EQ(filled(), 0);
}

TEST_F(FillingTest, edges_of_different_distance_are_no_surface) {
  const Upright box{2.5, -0.4, 0.4, 0.6};
  look([=](const Point& ray, int u, int v) {
    const Seen behind = floor_seen(ray, u, v);
    if (!box.meets(ray, behind.depth)) return behind;
    // Its right side is matched as if it were 4 m away.
    return Seen{u > 320 ? 4.0 : box.depth(ray), 150, box.inside(ray) < 6};
  });
  EXPECT_EQ(filled(), 0);
}

}  // namespace
}  // namespace vdisp
