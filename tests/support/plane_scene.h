// plane_scene.h: for tests: scenes of planes, and the floor and the map that the stages find in them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "daemon/stages/occupancy.h"
#include "daemon/stages/plane_floor.h"
#include "daemon/stages/surfaces.h"
#include "tests/support/picture.h"

namespace vdisp {

constexpr int width = 320, height = 240;
constexpr StereoView view{288, 160, 120, 0.09, 0};
constexpr double high = 0.8, pitch = 0.26;

/// What a ray meets: a distance along the view in m, 0 for nothing.
using Scene = std::function<double(const Point& ray)>;

/// Ground `below` m under the camera that is banked by `roll`.
inline Scene ground(double below, double roll = 0, double down = pitch) {
  return [=](const Point& ray) {
    const double fall = horizontal(ray, down, roll).y;
    return fall > 1e-6 ? below / fall : 0;
  };
}

/// An upright wall `ahead` m away, from the ground to `top` m over it, between two sides in m.
inline Scene with_wall(const Scene& scene, double ahead, double top, double left = -10, double right = 10) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, over = high - h.y * z, across = h.x * z;
    const double behind = scene(ray);
    return over > 0 && over < top && across > left && across < right && (behind == 0 || z < behind) ? z : behind;
  };
}

/// Ground that is level up to `edge` m ahead and then falls so steeply that nothing of it is seen; what stands there is seen over the edge.
inline Scene brow(double edge) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = h.y > 1e-6 ? high / h.y : 0;
    return h.z * z < edge ? z : 0;
  };
}

/// Level ground with a ditch from `near` to `far` m ahead, too deep to see its bottom.
inline Scene ditch(double near, double far) {
  const Scene flat = ground(high);
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray), ahead = h.z * z;
    return z > 0 && ahead > near && ahead < far ? far / h.z : z;
  };
}

/// Level ground, `deep` m lower from `edge` m ahead on to the right of `side`; a wall leads along the way between the two.
inline Scene kerb_beside(double edge, double side, double deep) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    double nearest = 0;
    const auto meets = [&](double z, bool there) {
      if (z > 0 && there && (nearest == 0 || z < nearest)) nearest = z;
    };
    const double up = high / h.y, down = (high + deep) / h.y, wall = side / h.x;
    meets(up, h.z * up < edge || h.x * up < side);
    meets(down, h.z * down > edge && h.x * down > side);
    meets(wall, h.z * wall > edge && h.y * wall > high && h.y * wall < high + deep);
    return nearest;
  };
}

/// A wall `ahead` m away that reaches from `bottom` to `top` m over the level of the floor, seen where the ground is not nearer.
inline Scene with_wall_from(const Scene& scene, double ahead, double bottom, double top, double half_width) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, up = high - h.y * z, behind = scene(ray);
    return up > bottom && up < top && std::abs(h.x * z) < half_width && (behind == 0 || z < behind) ? z : behind;
  };
}

struct PlaneScene : testing::Test {
  Config config;
  Machine machine;
  Picture disparity{Pixel::disparity16, width, height}, left{Pixel::gray8, width, height};
  Picture imu{record_spec<Imu>()};
  std::unique_ptr<PlaneFloor> stage;
  std::vector<std::unique_ptr<Picture>> floor, over, ground_map;
  int64_t ms = 0;
  Rejected nothing = Rejected::low_texture;  // why there is no disparity

  void SetUp() override {
    config.image_source.ndisp = 64;
    config.floor.model = "profile";
    disparity.image().camera = {static_cast<float>(view.f),
                                static_cast<float>(view.cx),
                                static_cast<float>(view.cy),
                                static_cast<float>(view.baseline),
                                0,
                                0,
                                64,
                                {}};
    left.fill<uint8_t>([](int, int) { return uint8_t{100}; });
    imu.image().set_blind(Reason::no_imu);
  }
  void see(const Scene& scene) {
    disparity.fill<int16_t>([&](int v, int u) {
      const double z = scene({(u - view.cx) / view.f, (v - view.cy) / view.f, 1});
      const long d = z > 0 ? std::lround(16 * view.disparity(z)) : 0;
      return d > 0 && d < 16 * 64 ? static_cast<int16_t>(d) : rejected(nothing);
    });
  }
  Outcome find(int64_t at_ms = 0) {
    if (!stage) stage = std::make_unique<PlaneFloor>(machine, config);
    disparity.image().timestamp_ns = at_ms * 1'000'000;
    return run_stage(*stage, {&disparity, &left, &imu}, floor);
  }
  const FloorModel& model() { return *record_of<FloorModel>(floor.at(1)->image()); }
  Reason reason() { return floor.at(0)->image().reason; }
  void map() {
    Surfaces surfaces(machine, config);
    ASSERT_EQ(run_stage(surfaces, {&disparity, floor[1].get(), &left}, over), Outcome::valid);
    Occupancy occupancy(machine, config);
    ASSERT_EQ(
        run_stage(occupancy, {&disparity, over[1].get(), over[0].get(), over[2].get(), over[3].get(), floor[1].get(), &left}, ground_map),
        Outcome::valid);
  }
  /// Twelve frames of level ground, as [mounting] says.
  void trust_mounting() {
    config.mounting.height = 0.8f;
    config.mounting.pitch = static_cast<float>(pitch);
    see(ground(high));
    for (int i = 0; i < 12; ++i) ASSERT_EQ(find(ms += 100), Outcome::valid) << i;
  }
  static int row_of(double ahead) { return 49 - static_cast<int>(ahead / 0.1); }
  static int column_of(double right) { return static_cast<int>(std::floor(right / 0.1 + 25.5)); }
  int risk(double ahead, double right) { return ground_map[0]->at<int8_t>(row_of(ahead), column_of(right)); }
  CellReason why(double ahead, double right) {
    return static_cast<CellReason>(ground_map[1]->at<uint8_t>(row_of(ahead), column_of(right)));
  }
};

}  // namespace vdisp
