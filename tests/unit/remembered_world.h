// remembered_world.h: the map with reasons, the odometry check, tracks and the fused map, stage by stage, over a drawn world.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/stages/fused_map.h"
#include "daemon/stages/occupancy.h"
#include "daemon/stages/odometry_check.h"
#include "daemon/stages/surfaces.h"
#include "daemon/stages/tracks.h"
#include "tests/support/drawn_world.h"
#include "tests/support/picture.h"

namespace vdisp {

inline constexpr double period = 0.05;

/// A stage, its outputs, and what it read last.
struct Stage {
  std::unique_ptr<ImageProcessor> stage;
  std::vector<std::unique_ptr<Picture>> out;
  std::vector<const Image*> in;
  std::vector<Image*> results;

  Stage(std::unique_ptr<ImageProcessor> made, const std::vector<Picture*>& inputs) : stage(std::move(made)) {
    std::vector<ImageSpec> specs;
    for (Picture* input : inputs) {
      in.push_back(&input->image());
      specs.push_back(input->spec());
    }
    for (const ImageSpec& spec : stage->check(specs)) {
      out.push_back(std::make_unique<Picture>(spec));
      results.push_back(&out.back()->image());
    }
  }
  void step() {
    for (Image* image : results) {
      image->describe_like(*in[0]);
      image->state = ImageState::valid;
    }
    ASSERT_EQ(stage->process(in, results), Outcome::valid);
  }
};

struct MemoryTest : testing::Test {
  Config config;
  Machine machine;
  DrawnWorld world;
  DrawnRover rover;
  double seconds = 0;
  Picture disparity{Pixel::disparity16, DrawnWorld::width, DrawnWorld::height}, left{Pixel::gray8, DrawnWorld::width, DrawnWorld::height};
  Picture floor{record_spec<FloorModel>()}, odometry{record_spec<Odometry>()}, last_tracks{record_spec<Tracks>()};
  std::unique_ptr<Stage> surfaces, occupancy, check, follow, fuse;

  void SetUp() override {
    config.image_source.ndisp = 64;
    config.floor.model = "plane";
    left.fill<uint8_t>([](int, int) { return uint8_t{100}; });
    last_tracks.image().set_blind(Reason::no_last_image);
    make_record<Odometry>(odometry.image());
    odometry.image().flags = flag_synthetic;
  }
  void build() {
    const StereoView& v = world.view;
    disparity.image().camera = {static_cast<float>(v.f),
                                static_cast<float>(v.cx),
                                static_cast<float>(v.cy),
                                static_cast<float>(v.baseline),
                                0,
                                0,
                                config.image_source.ndisp,
                                {}};
    surfaces = std::make_unique<Stage>(std::make_unique<Surfaces>(machine, config), std::vector{&disparity, &floor, &left});
    auto& over = surfaces->out;
    occupancy = std::make_unique<Stage>(std::make_unique<Occupancy>(machine, config),
                                        std::vector{&disparity, over[1].get(), over[0].get(), over[2].get(), over[3].get(), &floor, &left});
    auto& map = occupancy->out;
    check = std::make_unique<Stage>(std::make_unique<OdometryCheck>(config), std::vector{map[0].get(), &odometry, &last_tracks});
    follow = std::make_unique<Stage>(std::make_unique<ObstacleTracks>(config),
                                     std::vector{map[0].get(), map[1].get(), over[2].get(), over[0].get(), &floor, check->out[0].get()});
    fuse = std::make_unique<Stage>(std::make_unique<FusedMap>(config),
                                   std::vector{map[0].get(), map[1].get(), &disparity, &floor, check->out[0].get()});
  }
  /// The next frame, with odometry that tells the truth unless `told` is another.
  void see() { see(rover); }
  void see(const DrawnRover& told) {
    if (!fuse) build();
    seconds += period;
    Image& image = disparity.image();
    ++image.sequence;
    image.timestamp_ns = std::lround(seconds * 1e9);
    image.flags = flag_synthetic;
    world.draw(rover, seconds, config.image_source.ndisp, disparity);
    *floor.image().row<FloorModel>(0) = world.floor();
    Odometry& o = *odometry.image().row<Odometry>(0);
    o.timestamp_ns = image.timestamp_ns;
    o.x = told.x;
    o.y = told.y;
    o.yaw = told.yaw;
    o.speed = o.turn_rate = NAN;
    step();
  }
  void step() {
    for (Stage* run : {surfaces.get(), occupancy.get(), check.get(), follow.get(), fuse.get()}) run->step();
    std::memcpy(static_cast<void*>(&last_tracks.image()), static_cast<void*>(&follow->out[0]->image()), last_tracks.spec().bytes());
  }
  /// Frames while the rover drives straight on.
  void drive(double metres, double speed = 0.5) {
    for (double way = 0; way < metres - 1e-9; way += speed * period) {
      rover.x += speed * period * std::cos(rover.yaw);
      rover.y += speed * period * std::sin(rover.yaw);
      see();
    }
  }
  void stand(int frames) {
    for (int i = 0; i < frames; ++i) see();
  }
  const Memory& memory() { return *record_of<Memory>(check->out[0]->image()); }
  const Tracks& tracks() { return *record_of<Tracks>(follow->out[0]->image()); }
  /// Of the cell at a place of the odometry frame.
  std::pair<int, int> cell(double x, double y) {
    const GridGeometry& g = fuse->out[0]->image().grid;
    EXPECT_EQ(g.frame, grid_of_odometry);
    return {static_cast<int>(g.origin_row) - 1 - static_cast<int>(std::floor(x / 0.1)),
            static_cast<int>(std::floor(-y / 0.1)) + static_cast<int>(g.origin_column)};
  }
  int fused(double x, double y) {
    const auto [row, column] = cell(x, y);
    return fuse->out[0]->at<int8_t>(row, column);
  }
  CellReason why(double x, double y) {
    const auto [row, column] = cell(x, y);
    return CellReason{fuse->out[1]->at<uint8_t>(row, column)};
  }
  /// The largest value within a cell around.
  int near(double x, double y) {
    int most = -1;
    for (double dx : {-0.1, 0.0, 0.1})
      for (double dy : {-0.1, 0.0, 0.1}) most = std::max(most, fused(x + dx, y + dy));
    return most;
  }
  int occupied() {
    int count = 0;
    for (int row = 0; row < fuse->out[0]->spec().height; ++row)
      for (int column = 0; column < fuse->out[0]->spec().width; ++column) count += fuse->out[0]->at<int8_t>(row, column) >= occupied_from;
    return count;
  }
};

}  // namespace vdisp
