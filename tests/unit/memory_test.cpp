// memory_test.cpp: odometry check, tracks and fused map behind the real map with reasons, over boxes whose disparities are arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/stages/fused_map.h"
#include "daemon/stages/occupancy.h"
#include "daemon/stages/odometry_check.h"
#include "daemon/stages/surfaces.h"
#include "daemon/stages/tracks.h"
#include "tests/support/count_allocations.h"
#include "tests/support/drawn_world.h"

namespace vdisp {
namespace {

constexpr double period = 0.05;

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

TEST_F(MemoryTest, what_is_suspected_is_told_as_in_sight_and_is_an_obstacle_when_it_was_seen_again) {
  stand(1);
  fuse->stage->begin_anew();
  const auto once = [&] {
    Picture &percent = *occupancy->out[0], &reason = *occupancy->out[1];
    const auto there = [](int row, int column) { return std::abs(row - 30) <= 1 && std::abs(column - 25) <= 1; };
    percent.fill<int8_t>([&](int row, int column) { return static_cast<int8_t>(there(row, column) ? 64 : -1); });
    reason.fill<uint8_t>(
        [&](int row, int column) { return static_cast<uint8_t>(there(row, column) ? CellReason::obstacle : CellReason::out_of_view); });
    fuse->step();
  };
  once();
  EXPECT_EQ(fused(1.95, 0), -1);
  EXPECT_EQ(why(1.95, 0), CellReason::obstacle);
  EXPECT_EQ(why(2.45, 0), CellReason::out_of_view);
  once();
  EXPECT_GE(fused(1.95, 0), occupied_from);
}

TEST_F(MemoryTest, an_obstacle_is_kept_where_it_is_when_it_left_the_view) {
  world.boxes = {{3.0, 0.5, 0.3, 0.3, 0.5}};
  stand(4);
  EXPECT_GE(near(2.85, 0.5), occupied_from);
  EXPECT_EQ(why(2.85, 0.5), CellReason::obstacle);
  drive(4);
  EXPECT_GE(near(2.85, 0.5), occupied_from) << "now 1.15 m behind the rover";
  int remembered = 0;
  for (double dx : {-0.1, 0.0, 0.1}) remembered += why(2.85 + dx, 0.5) == CellReason::remembered_obstacle;
  EXPECT_GT(remembered, 0);
  EXPECT_GE(fused(1.5, 0), 0) << "ground that was driven over";
  EXPECT_LE(fused(1.5, 0), 30);
  EXPECT_EQ(why(1.5, 0), CellReason::remembered_floor);
}

TEST_F(MemoryTest, cells_of_a_box_stay_put_within_one_cell_while_the_rover_passes_it) {
  world.boxes = {{3.0, 0.0, 0.3, 0.6, 0.5}};
  rover = {0, -0.8, 0.2};
  stand(3);
  for (int i = 0; i < 50; ++i) {
    rover.yaw += 0.01;
    drive(0.03);
  }
  const auto& grid = fuse->out[0];
  int inside = 0;
  for (int row = 0; row < grid->spec().height; ++row) {
    for (int column = 0; column < grid->spec().width; ++column) {
      if (grid->at<int8_t>(row, column) < occupied_from) continue;
      const GridGeometry& g = grid->image().grid;
      const double x = (static_cast<double>(g.origin_row) - 0.5 - row) * 0.1,
                   y = -(column + 0.5 - static_cast<double>(g.origin_column)) * 0.1;
      EXPECT_LE(std::abs(x - 3), 0.15 + 0.1) << x << ' ' << y;
      EXPECT_LE(std::abs(y), 0.3 + 0.1) << x << ' ' << y;
      ++inside;
    }
  }
  EXPECT_GE(inside, 5) << "its front is 6 cells";
  EXPECT_LE(inside, 5 * 8);
}

TEST_F(MemoryTest, nothing_clears_an_obstacle_that_came_nearer_than_the_camera_can_see) {
  config.image_source.ndisp = 24;  // 288 px x 0.09 m / 23 px: 1.13 m
  world.least_depth = 1.13;        // and the ground behind it is "seen" through it
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5}};
  stand(4);
  ASSERT_GE(near(2.5, 0), occupied_from);
  drive(1.8);
  stand(20);
  EXPECT_GE(near(2.5, 0), occupied_from) << "0.7 m ahead";
}

TEST_F(MemoryTest, rays_that_see_through_it_clear_an_obstacle_in_three_frames) {
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 1}};
  stand(19);
  ASSERT_GE(near(2.5, 0), occupied_from);
  ASSERT_GT(occupied(), 4);
  stand(4);
  EXPECT_EQ(occupied(), 0);
}

TEST_F(MemoryTest, what_is_not_seen_clears_nothing_and_what_is_seen_beyond_does) {
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 1}};
  stand(19);
  ASSERT_GE(near(2.5, 0), occupied_from);
  world.ground_to = 2;
  stand(20);
  EXPECT_GE(near(2.5, 0), occupied_from) << "no texture there: it may still stand there";
  world.boxes.push_back({3.25, 0, 0.2, 4, 2});  // farther by more than matching is exact
  stand(4);
  EXPECT_LT(near(2.5, 0), occupied_from) << "a wall is seen through it, though not the floor it stood on";
}

TEST_F(MemoryTest, is_forgotten_with_time) {
  config.memory.keep = 1;
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 1}};
  stand(19);
  world.ground_to = 0.5;
  stand(16);
  EXPECT_GE(near(2.5, 0), occupied_from) << "after 0.8 s";
  stand(8);
  EXPECT_LT(near(2.5, 0), occupied_from) << "after 1.2 s";
}

TEST_F(MemoryTest, a_moving_obstacle_has_its_speed_and_leaves_no_trail) {
  for (const auto& [vx, vy] : {std::pair{0.0, 0.6}, {0.5, 0.0}, {-0.4, -0.3}}) {
    fuse.reset();
    seconds = 0;
    world.boxes = {{3.2 - vx, -vy, 0.3, 0.4, 0.8, vx, vy}};
    stand(40);
    ASSERT_EQ(tracks().count, 1u);
    const Track& t = tracks().tracks[0];
    EXPECT_NEAR(t.speed_x, vx, 0.12) << vx << ' ' << vy;
    EXPECT_NEAR(t.speed_y, vy, 0.12) << vx << ' ' << vy;
    EXPECT_TRUE(t.flags & Track::moving);
    EXPECT_NEAR(t.x, 3.2 - vx + 2 * vx - 0.15, 0.12);
    EXPECT_NEAR(t.y, -vy + 2 * vy, 0.12);
    EXPECT_NEAR(t.age_s, 39 * period, 1e-3);
    EXPECT_EQ(tracks().frame, grid_of_odometry);
    EXPECT_LT(occupied(), 30) << "4 x 3 cells, and three frames' way";
  }
}

TEST_F(MemoryTest, numbers_that_readers_hold_go_on_when_a_recording_begins) {
  world.boxes = {{3.2, 0, 0.3, 0.4, 0.8}};
  stand(5);
  ASSERT_EQ(tracks().count, 1u);
  const uint32_t id = tracks().tracks[0].id, forgotten = memory().forgotten;
  for (Stage* run : {surfaces.get(), occupancy.get(), check.get(), follow.get(), fuse.get()}) run->stage->begin_anew();
  see();
  EXPECT_EQ(tracks().count, 0u) << "nothing is told of what came before";
  stand(4);
  ASSERT_EQ(tracks().count, 1u);
  EXPECT_GT(tracks().tracks[0].id, id);
  EXPECT_GT(memory().forgotten, forgotten) << "coordinates of before mean nothing";
}

TEST_F(MemoryTest, from_a_driving_rover_too_what_stands_stands_and_what_moves_moves) {
  world.boxes = {{3.6, 0.9, 0.3, 0.3, 0.5}, {3.2, -1.2, 0.3, 0.4, 0.8, 0.0, 0.4}};
  drive(0.8, 0.4);
  ASSERT_EQ(tracks().count, 2u);
  for (const Track& t : {tracks().tracks[0], tracks().tracks[1]}) {
    const bool moves = t.y < 0.5f;
    EXPECT_NEAR(t.speed_x, 0, 0.12);
    EXPECT_NEAR(t.speed_y, moves ? 0.4 : 0, 0.12);
    EXPECT_EQ((t.flags & Track::moving) != 0, moves);
  }
}

TEST_F(MemoryTest, without_odometry_the_map_is_of_the_frame_and_says_so) {
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 1}};
  see();
  odometry.image().set_blind(Reason::no_odometry);
  stand(10);
  const Image& image = fuse->out[0]->image();
  EXPECT_EQ(memory().state, MemoryState::frame_only);
  EXPECT_EQ(memory().cause, MemoryCause::no_odometry);
  EXPECT_TRUE(std::isnan(memory().x));
  EXPECT_EQ(image.grid.frame, grid_of_camera);
  EXPECT_EQ(image.flags & flag_memory, 0u);
  EXPECT_EQ(tracks().frame, 0u);
  EXPECT_EQ(static_cast<float>(image.spec.height / 2), image.grid.origin_row);
  // Cell by cell the frame's, the camera at the origin.
  const Image& frame = occupancy->out[0]->image();
  for (int row = 0; row < frame.spec.height; ++row) {
    for (int column = 0; column < frame.spec.width; ++column) {
      const int r = static_cast<int>(image.grid.origin_row) - frame.spec.height + row;
      const int c = static_cast<int>(image.grid.origin_column - static_cast<float>(frame.spec.width) / 2) + column;
      ASSERT_EQ(image.row<int8_t>(r)[c], frame.row<int8_t>(row)[column]);
    }
  }
  stand(15);
  EXPECT_EQ(occupied(), 0) << "what is gone is gone at once";
}

TEST_F(MemoryTest, a_short_pause_of_odometry_forgets_nothing_and_a_long_one_all) {
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 1}};
  stand(19);
  world.ground_to = 1;
  odometry.image().set_blind(Reason::no_odometry);
  stand(10);
  odometry.image().state = ImageState::valid;
  see();
  EXPECT_EQ(memory().forgotten, 0u);
  EXPECT_GE(near(2.5, 0), occupied_from);
  odometry.image().set_blind(Reason::no_odometry);
  stand(22);
  odometry.image().state = ImageState::valid;
  see();
  EXPECT_EQ(memory().forgotten, 1u);
  EXPECT_EQ(memory().cause, MemoryCause::pause);
  EXPECT_EQ(occupied(), 0);
}

TEST_F(MemoryTest, a_jump_a_new_frame_and_time_that_runs_backwards_forget_all) {
  world.boxes = {{2.6, 0, 0.2, 0.6, 0.5, 0, 0, 0, 0.47}};
  stand(9);
  ASSERT_GT(occupied(), 4);
  world.ground_to = 1;
  rover = {0.6, 0, 0};  // 12 m/s
  see();
  EXPECT_EQ(memory().cause, MemoryCause::jump);
  EXPECT_EQ(memory().state, MemoryState::fused) << "it begins anew";
  EXPECT_EQ(memory().forgotten, 1u);
  EXPECT_EQ(occupied(), 0);
  ++odometry.image().row<Odometry>(0)->frame;
  see();
  EXPECT_EQ(memory().cause, MemoryCause::anew);
  EXPECT_EQ(memory().forgotten, 2u);
  seconds -= 3 * period;
  see();
  EXPECT_EQ(memory().cause, MemoryCause::backwards);
  EXPECT_GE(memory().forgotten, 3u);
  const uint32_t before = memory().forgotten;
  stand(3);
  EXPECT_EQ(memory().forgotten, before);
}

TEST_F(MemoryTest, numbers_that_are_none_are_no_odometry) {
  stand(2);
  see({NAN, 0, 0});
  EXPECT_EQ(memory().cause, MemoryCause::no_odometry);
  see({0, 0, INFINITY});
  EXPECT_EQ(memory().state, MemoryState::frame_only);
  see();
  EXPECT_EQ(memory().state, MemoryState::fused);
  EXPECT_EQ(memory().forgotten, 0u);
}

TEST_F(MemoryTest, odometry_of_a_socket_is_carried_to_the_frame_and_not_farther_than_maxLag) {
  stand(1);
  odometry.image().flags = 0;  // by the socket; frame and odometry have one clock
  Odometry& o = *odometry.image().row<Odometry>(0);
  const auto sample = [&](double at, double x) {
    seconds += period;
    disparity.image().timestamp_ns = std::lround(seconds * 1e9);
    disparity.image().flags = 0;
    o.timestamp_ns = std::lround(at * 1e9);
    o.x = x;
    step();
  };
  sample(seconds, 0);     // 0.05 s old
  sample(seconds, 0.05);  // 1 m/s
  EXPECT_NEAR(memory().lag_s, period, 1e-9);
  EXPECT_NEAR(memory().x, 0.1, 1e-6) << "carried on at the speed of the last two";
  o.speed = 0.4;
  o.turn_rate = 0;
  sample(seconds, 0.1);
  EXPECT_NEAR(memory().x, 0.12, 1e-6) << "at the speed told";
  sample(seconds - 0.3, 0.1);
  EXPECT_EQ(memory().cause, MemoryCause::late);
  EXPECT_EQ(memory().forgotten, 1u) << "older than the one before";
  sample(seconds - 0.14, 0.1);
  EXPECT_EQ(memory().state, MemoryState::fused) << "0.19 s";
  sample(seconds - 0.13, 0.1);
  sample(seconds - 0.17, 0.1);
  EXPECT_EQ(memory().cause, MemoryCause::late) << "0.22 s";
}

TEST_F(MemoryTest, odometry_that_stands_while_all_obstacles_come_nearer_is_not_believed) {
  world.boxes = {{3.0, 0.4, 0.3, 0.3, 0.5}, {4.0, -0.2, 0.3, 0.4, 0.6}, {3.3, -0.9, 0.4, 0.3, 0.7}};
  const DrawnRover stands;
  int contradicted = -1;
  for (int i = 0; i < 60 && contradicted < 0; ++i) {
    rover.x += 0.4 * period;
    see(stands);
    if (memory().state == MemoryState::frame_only) contradicted = i;
  }
  EXPECT_GT(contradicted, 10);
  EXPECT_LT(contradicted * period, 2.0);
  EXPECT_EQ(memory().cause, MemoryCause::contradicted);
  EXPECT_EQ(memory().forgotten, 1u);
  EXPECT_EQ(fuse->out[0]->image().grid.frame, grid_of_camera);
}

TEST_F(MemoryTest, true_odometry_is_not_contradicted_by_obstacles_that_stand_and_one_that_moves) {
  world.boxes = {{3.0, 0.9, 0.3, 0.3, 0.5}, {4.0, 0.0, 0.3, 0.4, 0.6}, {3.5, -1.6, 0.4, 0.3, 0.7, 0, 0.4}};
  drive(1.2, 0.4);
  EXPECT_EQ(memory().forgotten, 0u);
  EXPECT_EQ(memory().state, MemoryState::fused);
}

TEST_F(MemoryTest, the_grid_follows_the_rover_by_whole_cells) {
  config.memory.range = 3;
  world.boxes = {{3.0, 0.8, 0.3, 0.3, 0.5}};
  stand(3);
  EXPECT_EQ(fuse->out[0]->spec().width, 2 * (30 + 8));
  const float before = fuse->out[0]->image().grid.origin_row;
  drive(3, 1);
  const float after = fuse->out[0]->image().grid.origin_row;
  EXPECT_GT(after, before);
  EXPECT_EQ(after, std::floor(after));
  EXPECT_GE(near(2.85, 0.8), occupied_from);
  drive(5, 1);
  EXPECT_EQ(occupied(), 0) << "5.1 m behind it is out of the grid";
}

TEST_F(MemoryTest, takes_nothing_from_the_heap) {
  world.boxes = {{3.0, 0.9, 0.3, 0.3, 0.5}};
  drive(0.5);
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 20; ++i) step();
  EXPECT_EQ(allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace vdisp
