// tree_test.cpp: the whole tree on the simulator: what stands is in the map, bare ground is not.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace vdisp {
namespace {

struct TreeTest : testing::Test {
  Config config;
  Machine machine;
  Inputs inputs{config};
  Driver driver{1};
  std::map<std::string, BufferOutlet*> outlets;

  void SetUp() override {
    config.image_source.source = "sim";
    config.sim.rate = 0;
  }
  void build() {
    build_tree(driver, open_source(config), machine, config, inputs);
    driver.connect([this](const std::string& topic, const ImageSpec& spec) {
      auto outlet = std::make_unique<BufferOutlet>(spec);
      outlets[topic] = outlet.get();
      return outlet;
    });
    driver.need_all();
  }
  const Image& image(const std::string& topic) { return outlets.at(topic)->loan(); }
  int obstacle_cells() {
    const Image& map = image("map");
    int cells = 0;
    for (int row = 0; row < map.spec.height; ++row)
      for (int column = 0; column < map.spec.width; ++column) cells += map.row<int16_t>(row)[column] >= config.map.minCount;
    return cells;
  }
};

TEST_F(TreeTest, bare_ground_is_no_obstacle) {
  // With OpenCV's filters alone every other frame of this ground has an obstacle cell: a slanted floor fits a square window badly.
  config.sim.scene = "empty";
  config.sim.seed = 5;
  build();
  for (int frame = 0; frame < 30; ++frame) {
    ASSERT_EQ(driver.step(), Outcome::valid);
    ASSERT_TRUE(image("map").valid());
    EXPECT_EQ(obstacle_cells(), 0) << "frame " << frame;
  }
}

TEST_F(TreeTest, what_stands_on_the_ground_is_in_the_map) {
  config.sim.scene = "obstacles";
  build();
  ASSERT_EQ(driver.step(), Outcome::valid);
  const Image& map = image("map");
  const TruthScene& scene = *record_of<TruthScene>(image("truth/scene"));
  for (uint32_t i = 0; i < scene.count; ++i) {
    const TruthObject& object = scene.objects[i];
    int count = 0;
    for (int row = 0; row < map.spec.height; ++row) {
      for (int column = 0; column < map.spec.width; ++column) {
        const float x = (static_cast<float>(column) + 0.5f - map.grid.origin_column) * map.grid.cell;
        const float z = (map.grid.origin_row - static_cast<float>(row) - 0.5f) * map.grid.cell;
        const float reach = std::max(object.width, object.depth) / 2 + 2 * map.grid.cell;
        if (std::hypot(x - object.x, z - object.z) < reach) count += map.row<int16_t>(row)[column];
      }
    }
    EXPECT_GE(count, 100) << "object " << i + 1 << " at " << object.x << ", " << object.z;
  }
}

TEST_F(TreeTest, without_a_detector_there_is_stereo_only) {
  config.main.detectors = "none";
  build();
  ASSERT_EQ(driver.step(), Outcome::valid);
  EXPECT_TRUE(image("disparity").valid());
  EXPECT_EQ(outlets.count("map"), 0u);
}

TEST_F(TreeTest, images_that_do_not_fit_the_search_are_refused_by_name) {
  config.sim.width = 200;
  config.image_source.ndisp = 256;
  try {
    build();
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_NE(std::string(error.what()).find("stage 'disparity' of 'left' (gray8 200x480), 'right'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vdisp
