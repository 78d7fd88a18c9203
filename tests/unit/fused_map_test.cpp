// fused_map_test.cpp: what the map that remembers keeps, clears and forgets, over boxes whose disparities are arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/fused_map.h"

#include "tests/unit/remembered_world.h"

namespace vdisp {
namespace {

/// Nine cells about 1.95 m ahead that say what a test gives them, in a frame that sees nothing else.
struct FusedPatchTest : MemoryTest {
  void begin() {
    stand(1);
    fuse->stage->begin_anew();
  }
  void see_patch(int value, CellReason told, int frames = 1) {
    Picture &percent = *occupancy->out[0], &reason = *occupancy->out[1];
    const auto there = [](int row, int column) { return std::abs(row - 30) <= 1 && std::abs(column - 25) <= 1; };
    percent.fill<int8_t>([&](int row, int column) { return static_cast<int8_t>(there(row, column) ? value : -1); });
    reason.fill<uint8_t>([&](int row, int column) { return static_cast<uint8_t>(there(row, column) ? told : CellReason::out_of_view); });
    for (int i = 0; i < frames; ++i) fuse->step();
  }
};

TEST_F(FusedPatchTest, what_is_suspected_is_told_as_in_sight_and_is_an_obstacle_when_it_was_seen_again) {
  begin();
  see_patch(64, CellReason::obstacle);
  EXPECT_EQ(fused(1.95, 0), -1);
  EXPECT_EQ(why(1.95, 0), CellReason::obstacle);
  EXPECT_EQ(why(2.45, 0), CellReason::out_of_view);
  see_patch(64, CellReason::obstacle);
  EXPECT_GE(fused(1.95, 0), occupied_from);
}

TEST_F(FusedPatchTest, what_is_suspected_and_likelier_floor_adds_up_to_nothing) {
  for (const int value : {free_up_to + 1, 45, 49}) {
    begin();
    see_patch(value, CellReason::floor, 50);
    EXPECT_EQ(fused(1.95, 0), -1) << value << ": no free ground, however often, and no obstacle";
    EXPECT_EQ(why(1.95, 0), CellReason::obstacle) << value;
  }
  begin();
  see_patch(free_up_to, CellReason::floor, 50);
  EXPECT_EQ(fused(1.95, 0), 0);
}

TEST_F(FusedPatchTest, what_is_suspected_and_not_known_is_told_as_this_frame_has_it) {
  begin();
  see_patch(55, CellReason::drop_off);
  EXPECT_EQ(fused(1.95, 0), -1);
  EXPECT_EQ(why(1.95, 0), CellReason::drop_off);
  see_patch(45, CellReason::floor);
  EXPECT_EQ(fused(1.95, 0), -1);
  EXPECT_EQ(why(1.95, 0), CellReason::obstacle);
}

TEST_F(FusedPatchTest, ground_that_was_seen_free_stays_so_where_little_is_suspected) {
  begin();
  see_patch(0, CellReason::floor, 5);
  see_patch(49, CellReason::floor, 10);
  EXPECT_EQ(fused(1.95, 0), 0);
  EXPECT_EQ(why(1.95, 0), CellReason::floor) << "it is seen, and not only remembered";
  see_patch(64, CellReason::floor);
  EXPECT_GE(fused(1.95, 0), 0);
  EXPECT_EQ(why(1.95, 0), CellReason::floor);
}

TEST_F(FusedPatchTest, what_is_doubted_is_suspected_on_free_ground_in_its_third_frame_and_an_obstacle_in_its_sixth) {
  begin();
  see_patch(0, CellReason::floor, 5);
  see_patch(64, CellReason::obstacle, 2);
  EXPECT_GE(fused(1.95, 0), 0);
  see_patch(64, CellReason::obstacle);
  EXPECT_EQ(fused(1.95, 0), -1);
  EXPECT_EQ(why(1.95, 0), CellReason::obstacle);
  see_patch(64, CellReason::obstacle, 2);
  EXPECT_LT(fused(1.95, 0), occupied_from);
  see_patch(64, CellReason::obstacle);
  EXPECT_GE(fused(1.95, 0), occupied_from);
}

TEST_F(FusedPatchTest, a_lone_sure_frame_makes_free_ground_unknown_because_of_an_obstacle_until_the_next) {
  for (const auto& [value, told] : {std::pair{90, CellReason::obstacle}, {100, CellReason::obstacle}, {100, CellReason::drop_off}}) {
    begin();
    see_patch(0, CellReason::floor, 5);
    see_patch(value, told);
    EXPECT_EQ(fused(1.95, 0), -1) << value;
    EXPECT_EQ(why(1.95, 0), told) << value;
    see_patch(0, CellReason::floor);
    EXPECT_GE(fused(1.95, 0), 0) << value;
    EXPECT_LE(fused(1.95, 0), 30) << value;
  }
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

}  // namespace
}  // namespace vdisp
