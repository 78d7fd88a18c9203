// map_driver_test.cpp: the map's corridor: obstacles, what may stand there, unknown ground, and where to evade.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map_driver.h"

#include "tests/unit/way_map.h"

namespace vdisp {
namespace {

TEST_F(MapDriverTest, bare_ground_is_free_and_clear) {
  const MapWay way = look();
  EXPECT_TRUE(way.free);
  EXPECT_EQ(way.clearness, 1);
  EXPECT_EQ(way.corridor_m, 3);
}

TEST_F(MapDriverTest, the_nearest_obstacle_in_the_corridor_ends_it) {
  obstacle(2.55, 0);
  obstacle(2.05, 0.25);
  obstacle(1.55, 0.4);  // beside it: 0.2 + 0.1 m
  const MapWay way = look();
  EXPECT_NEAR(way.corridor_m, 2.05, 1e-6);
  EXPECT_TRUE(way.free);
  EXPECT_NEAR(way.clearness, 1.05 / 2, 1e-6);
  config.decide.margin = 0.25;
  EXPECT_NEAR(look().corridor_m, 1.55, 1e-6);
  config.decide.margin = 0;
  EXPECT_NEAR(look().corridor_m, 2.55, 1e-6);
}

TEST_F(MapDriverTest, what_is_nearer_than_near_is_turned_from_to_the_freer_side) {
  obstacle(0.95, 0.1);
  EXPECT_FALSE(look().free);
  EXPECT_EQ(look().clearness, 0);
  EXPECT_FALSE(look().left) << "it stands more to the left";
  for (double right = 0; right < 1.2; right += 0.1) obstacle(0.95, -right - 0.05);
  EXPECT_TRUE(look().left);
}

TEST_F(MapDriverTest, unknown_ground_near_the_rover_is_not_free) {
  for (double ahead = 0.45; ahead < 1; ahead += 0.1)
    for (double left = -0.25; left < 0.26; left += 0.1) put(ahead, left, -1, CellReason::no_texture);
  EXPECT_FALSE(look().free);
  // Far ones, few ones, and those that the camera does not look at, say nothing.
  for (const CellReason why : {CellReason::out_of_view, CellReason::too_near}) {
    for (double ahead = 0.45; ahead < 0.8; ahead += 0.1)
      for (double left = -0.25; left < 0.26; left += 0.1) put(ahead, left, -1, why);
    for (double ahead = 0.85; ahead < 1.2; ahead += 0.1)
      for (double left = -0.25; left < 0.26; left += 0.1) put(ahead, left, 0, CellReason::floor);
    put(0.95, 0.05, -1, CellReason::no_texture);
    EXPECT_TRUE(look().free) << name(why);
  }
}

TEST_F(MapDriverTest, what_may_stand_there_is_come_near_to_slowly_and_turned_from_when_near) {
  put(1.55, 0, 64, CellReason::obstacle);
  EXPECT_TRUE(look().free) << "little is seen of it: nothing to turn from yet";
  EXPECT_NEAR(look().clearness, 0.55 / 2, 1e-6);
  EXPECT_EQ(look().corridor_m, 3);
  put(1.55, 0, 41, CellReason::floor);
  EXPECT_NEAR(look().clearness, 0.55 / 2, 1e-6);
  put(1.55, 0, -1, CellReason::obstacle);
  EXPECT_NEAR(look().clearness, 0.55 / 2, 1e-6) << "a map that remembers has seen too little of it";
  put(1.55, 0, 40, CellReason::floor);
  EXPECT_EQ(look().clearness, 1);
  put(1.55, 0.45, 64, CellReason::obstacle);
  EXPECT_EQ(look().clearness, 1) << "beside the corridor";
}

TEST_F(MapDriverTest, what_may_stand_nearer_than_near_is_turned_from) {
  for (const auto& [value, why] :
       {std::pair{41, CellReason::floor}, {64, CellReason::obstacle}, {-1, CellReason::obstacle}, {-1, CellReason::drop_off}}) {
    put(1.05, 0.1, value, why);
    EXPECT_TRUE(look().free) << value << ' ' << name(why);
    EXPECT_NEAR(look().clearness, 0.05 / 2, 1e-6) << value << ' ' << name(why);
    put(1.05, 0.1, 0, CellReason::floor);
    put(0.95, 0.1, value, why);
    EXPECT_FALSE(look().free) << value << ' ' << name(why);
    EXPECT_NEAR(look().corridor_m, 0.95, 1e-6) << value << ' ' << name(why);
    EXPECT_FALSE(look().left) << "it stands more to the left";
    put(0.95, 0.1, 0, CellReason::floor);
    EXPECT_TRUE(look().free);
  }
}

TEST_F(MapDriverTest, how_near_it_may_stand_is_judged_along_the_corridor_as_of_an_obstacle) {
  config.decide.width = 1.2;
  put(0.95, 0.6, 64, CellReason::obstacle);
  EXPECT_FALSE(look().free) << "1.12 m away, and 0.95 m ahead";
  put(0.95, 0.6, 0, CellReason::floor);
  EXPECT_TRUE(look().free);
  obstacle(0.95, 0);
  EXPECT_TRUE(look().left) << "both ways are free";
  put(0.35, 1.0, 64, CellReason::obstacle);
  EXPECT_FALSE(look().left) << "1.06 m away, and 0.99 m ahead after a turn of 50 degrees, the first that evades the obstacle";
}

TEST_F(MapDriverTest, what_may_stand_beyond_near_is_no_unknown_ground) {
  // Seen from 0.95 m on: the first 0.3 m decide, and something may stand all over the farther part of them.
  for (double left = -0.25; left < 0.26; left += 0.1) {
    for (double ahead = 0.45; ahead < 0.9; ahead += 0.1) put(ahead, left, -1, CellReason::too_near);
    for (const double ahead : {1.05, 1.15, 1.25}) put(ahead, left, ahead < 1.2 ? 64 : -1, CellReason::obstacle);
  }
  EXPECT_TRUE(look().free) << "slowly on: it is not near yet";
  EXPECT_NEAR(look().clearness, 0.05 / 2, 1e-6);
  for (double left = -0.25; left < 0.26; left += 0.1)
    for (const double ahead : {1.05, 1.15, 1.25}) put(ahead, left, -1, CellReason::no_texture);
  EXPECT_FALSE(look().free) << "nothing is known of it";
}

TEST_F(MapDriverTest, what_stands_or_may_stand_in_the_first_cells_in_view_is_turned_from_where_these_lie_beyond_near) {
  const auto see_from = [&](double nearest) {
    for (double ahead = 0.05; ahead < nearest; ahead += 0.1)
      for (double left = -0.55; left < 0.56; left += 0.1) put(ahead, left, -1, CellReason::too_near);
  };
  const auto lies = [&](double to, int value, CellReason why) {
    for (double ahead = 1.25; ahead < to; ahead += 0.1)
      for (double left = -0.25; left < 0.26; left += 0.1) put(ahead, left, value, why);
  };
  see_from(1.2);
  for (const auto& [value, why] :
       {std::pair{41, CellReason::floor}, {64, CellReason::obstacle}, {100, CellReason::obstacle}, {-1, CellReason::drop_off}}) {
    lies(1.5, value, why);
    EXPECT_FALSE(look().free) << value << ' ' << name(why) << ": it would be out of view when it is near";
  }
  lies(1.5, 0, CellReason::floor);
  EXPECT_TRUE(look().free);
  put(1.35, 0.05, 64, CellReason::obstacle);
  EXPECT_FALSE(look().free);
  EXPECT_NEAR(look().corridor_m, 1.35, 1e-6);
  put(1.35, 0.05, 0, CellReason::floor);
  obstacle(1.65, 0.05);
  EXPECT_TRUE(look().free) << "not among the first 0.3 m";
  // All that is in view of the corridor may stand, from beyond near to far.
  lies(3, 45, CellReason::floor);
  EXPECT_FALSE(look().free);
  EXPECT_NEAR(look().corridor_m, 1.25, 1e-6);
}

TEST_F(MapDriverTest, with_no_ground_in_sight_nothing_is_free) {
  grid.fill<int8_t>([](int, int) { return int8_t{-1}; });
  reason.fill<uint8_t>([](int, int) { return static_cast<uint8_t>(CellReason::out_of_view); });
  EXPECT_FALSE(look().free);
}

TEST_F(MapDriverTest, the_grid_may_lie_otherwise_than_the_rover) {
  reason.fill<uint8_t>([](int, int) { return static_cast<uint8_t>(CellReason::floor); });
  grid.fill<int8_t>([](int, int) { return int8_t{0}; });
  obstacle(2.05, 0);
  obstacle(0.15, -2.4);
  // The grid's origin 0.5 m before the rover's.
  grid.image().grid.pose_x = 0.5f;
  EXPECT_NEAR(look().corridor_m, 2.55, 1e-6);
  // The grid is turned to the left by a right angle: what is ahead in it stands to the rover's left, what is to its right is ahead.
  grid.image().grid.pose_x = 0;
  grid.image().grid.pose_yaw = static_cast<float>(M_PI / 2);
  EXPECT_NEAR(look().corridor_m, 2.4, 1e-6);
  grid.image().grid.pose_yaw = 0;
  grid.image().grid.pose_y = 1;
  EXPECT_EQ(look().corridor_m, 3);
}

TEST_F(MapDriverTest, the_papers_counts_are_obstacles_from_min_count_on) {
  Picture counts(Pixel::count16, columns, rows);
  counts.image().grid = grid.image().grid;
  counts.at<int16_t>(rows - 1 - 8, columns / 2) = 2;
  MapDriver driver(config);
  driver.prepare(counts.spec());
  EXPECT_TRUE(driver.look(counts.image(), nullptr).free);
  counts.at<int16_t>(rows - 1 - 8, columns / 2) = 3;
  EXPECT_NEAR(driver.look(counts.image(), nullptr).corridor_m, 0.85, 1e-6);
}

}  // namespace
}  // namespace vdisp
