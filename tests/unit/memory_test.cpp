// memory_test.cpp: odometry check and tracks behind the real map with reasons, and when all is forgotten.
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/count_allocations.h"
#include "tests/unit/remembered_world.h"

namespace vdisp {
namespace {

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

TEST_F(MemoryTest, takes_nothing_from_the_heap) {
  world.boxes = {{3.0, 0.9, 0.3, 0.3, 0.5}};
  drive(0.5);
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 20; ++i) step();
  EXPECT_EQ(allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace vdisp
