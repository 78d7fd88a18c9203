// plane_scene.h: for tests: the floor and the map that the stages find in a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "daemon/stages/occupancy.h"
#include "daemon/stages/plane_floor.h"
#include "daemon/stages/surfaces.h"
#include "tests/support/picture.h"
#include "tests/support/scenes.h"

namespace vdisp {

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
