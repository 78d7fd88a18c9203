// navigation_test.cpp: planning where something changed equals planning anew; what cannot be followed is read whole; ways are passable.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/examples/navigation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "daemon/stages/map_changes.h"
#include "ipc/examples/followed_map.h"
#include "ipc/examples/planned.h"
#include "tests/support/picture.h"

namespace planner {
namespace {

using vdisp::Picture;
using vdisp::Pixel;

constexpr double never = INFINITY;

Navigation anew(const Navigation& other) {
  Navigation fresh(other.rows(), other.columns());
  for (int r = 0; r < other.rows(); ++r)
    for (int c = 0; c < other.columns(); ++c) fresh.set_speed({r, c}, other.speed({r, c}));
  fresh.set_goal(other.goal());
  fresh.propagate();
  return fresh;
}

/// To the last bit.
void expect_as_anew(const Navigation& incremental, int when) {
  const Navigation fresh = anew(incremental);
  for (int r = 0; r < fresh.rows(); ++r)
    for (int c = 0; c < fresh.columns(); ++c) ASSERT_EQ(incremental.cost({r, c}), fresh.cost({r, c})) << when << ": " << r << ' ' << c;
}

/// |grad T| = 1 / speed solved in another way: all cells again and again until none changes.
std::vector<double> by_sweeps(const Navigation& grid) {
  const int rows = grid.rows(), columns = grid.columns();
  std::vector<double> t(static_cast<size_t>(rows * columns), never);
  const auto at = [&](int r, int c) {
    return r < 0 || c < 0 || r >= rows || c >= columns ? never : t[static_cast<size_t>(r * columns + c)];
  };
  for (bool again = true; again;) {
    again = false;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const double speed = grid.speed({r, c});
        if (speed == 0) continue;
        const double v = std::min(at(r - 1, c), at(r + 1, c)), h = std::min(at(r, c - 1), at(r, c + 1)), f = 1 / speed;
        double now = std::min(v, h) + f;
        if (std::abs(v - h) < f) {  // x^2 * 2 - 2 x (v + h) + v^2 + h^2 - f^2 = 0
          const double p = v + h, q = v * v + h * h - f * f;
          now = (2 * p + std::sqrt(4 * p * p - 8 * q)) / 4;
        }
        if (Cell{r, c} == grid.goal()) now = 0;
        if (now < at(r, c) - 1e-13) {
          t[static_cast<size_t>(r * columns + c)] = now;
          again = true;
        }
      }
    }
  }
  return t;
}

struct Box {
  double row, column, down, right;
  int size;
};

/// Obstacles that move about, bounce, and cover each other, over ground of other speeds.
struct World {
  std::mt19937 random;
  std::vector<Box> boxes;
  std::vector<double> ground;
  int rows, columns;

  World(unsigned seed, int r, int c, int count) : random(seed), ground(static_cast<size_t>(r * c)), rows(r), columns(c) {
    std::uniform_real_distribution<double> any(0, 1);
    for (double& speed : ground) speed = any(random) < 0.7 ? 1 : 0.2 + 0.8 * any(random);
    for (int i = 0; i < count; ++i)
      boxes.push_back({any(random) * r, any(random) * c, any(random) * 2 - 1, any(random) * 2 - 1, 1 + static_cast<int>(random() % 5)});
  }
  void move() {
    for (Box& box : boxes) {
      box.row += box.down;
      box.column += box.right;
      if (box.row < 0 || box.row >= rows) box.down = -box.down;
      if (box.column < 0 || box.column >= columns) box.right = -box.right;
    }
    ground[random() % ground.size()] = 0.1 + 0.9 * static_cast<double>(random() % 1000) / 1000;
  }
  bool blocked(int r, int c) const {
    return std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) {
      return r >= std::floor(box.row) && r < std::floor(box.row) + box.size && c >= std::floor(box.column) &&
             c < std::floor(box.column) + box.size;
    });
  }
  void show(Navigation& navigation) const {
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) navigation.set_speed({r, c}, blocked(r, c) ? 0 : ground[static_cast<size_t>(r * columns + c)]);
  }
};

/// Every 1/100 cell of the way lies in a cell that is no obstacle; costs fall from cell to cell; it ends at the goal.
void expect_passable(const Navigation& navigation, const std::vector<Place>& way, const std::string& when) {
  ASSERT_GE(way.size(), 2u) << when;
  EXPECT_EQ(cell_at(way.back()), navigation.goal()) << when;
  double last = never;
  for (size_t i = 1; i < way.size(); ++i) {
    for (int part = 0; part <= 100; ++part) {
      const double t = part / 100.0;
      const Cell cell =
          cell_at({way[i - 1].row + t * (way[i].row - way[i - 1].row), way[i - 1].column + t * (way[i].column - way[i - 1].column)});
      ASSERT_TRUE(navigation.holds(cell)) << when;
      ASSERT_GT(navigation.speed(cell), 0) << when << ": cell " << cell.row << ' ' << cell.column;
    }
    const double cost = navigation.cost(cell_at(way[i]));
    ASSERT_LE(cost, last) << when;
    if (!(cell_at(way[i]) == cell_at(way[i - 1]))) {
      ASSERT_LT(cost, navigation.cost(cell_at(way[i - 1]))) << when;
    }
    last = cost;
  }
}

TEST(Navigation, costs_on_free_ground_are_distances) {
  Navigation navigation(41, 41);
  navigation.set_goal({20, 20});
  navigation.propagate();
  for (int i = 0; i <= 20; ++i) {
    EXPECT_EQ(navigation.cost({20, 20 + i}), i) << "along an axis exactly";
    EXPECT_EQ(navigation.cost({20 - i, 20}), i);
  }
  for (int r = 0; r < 41; ++r) {
    for (int c = 0; c < 41; ++c) {
      const double distance = std::hypot(r - 20, c - 20);
      EXPECT_GE(navigation.cost({r, c}), distance - 1e-9);
      EXPECT_LE(navigation.cost({r, c}), distance + 0.7 + 0.05 * distance) << "not the 41 % of steps along the axes: " << r << ' ' << c;
    }
  }
}

TEST(Navigation, costs_solve_the_equation_as_sweeps_do) {
  World world(11, 30, 40, 8);
  Navigation navigation(30, 40);
  navigation.set_goal({2, 37});
  for (int i = 0; i < 20; ++i) {
    world.move();
    world.show(navigation);
    navigation.propagate();
    const auto truth = by_sweeps(navigation);
    for (int r = 0; r < 30; ++r) {
      for (int c = 0; c < 40; ++c) {
        const double t = truth[static_cast<size_t>(r * 40 + c)];
        if (std::isinf(t))
          ASSERT_EQ(navigation.cost({r, c}), t);
        else
          ASSERT_NEAR(navigation.cost({r, c}), t, 1e-9) << i << ": " << r << ' ' << c;
      }
    }
  }
}

struct MovingObstacles : testing::TestWithParam<unsigned> {};

TEST_P(MovingObstacles, planning_where_it_changed_equals_planning_anew) {
  World world(GetParam(), 50, 51, 4 + static_cast<int>(GetParam()));
  Navigation navigation(50, 51);
  navigation.set_goal({static_cast<int>(GetParam() * 7 % 50), static_cast<int>(GetParam() * 13 % 51)});
  size_t most = 0;
  for (int i = 0; i < 100; ++i) {
    world.move();
    world.show(navigation);
    most = std::max(most, navigation.propagate());
    expect_as_anew(navigation, i);
    if (HasFatalFailure()) return;
  }
  EXPECT_LE(most, 2u * 50 * 51) << "each cell at most twice: once forgotten, once found";
}

TEST_P(MovingObstacles, ways_are_passable_and_go_down) {
  World world(GetParam() + 1000, 50, 51, 10);
  Navigation navigation(50, 51);
  navigation.set_goal({3, 25});
  int ways = 0;
  for (int i = 0; i < 40; ++i) {
    world.move();
    world.show(navigation);
    navigation.propagate();
    for (const Place start : {Place{49.5, 25.5}, Place{49.9, 0.1}, Place{20, 50.99}, Place{30.3, 10.7}}) {
      const auto way = navigation.path(start);
      ASSERT_EQ(way.empty(), std::isinf(navigation.cost(cell_at(start)))) << "a way exactly where there is one";
      if (way.empty()) continue;
      ++ways;
      expect_passable(navigation, way, std::to_string(i));
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(ways, 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MovingObstacles, testing::Range(1u, 11u));

TEST(Navigation, obstacles_only_added_until_no_way_is_left_and_only_removed_until_all_is_free) {
  std::mt19937 random(2);
  std::vector<Cell> cells;
  for (int r = 0; r < 30; ++r)
    for (int c = 0; c < 30; ++c) cells.push_back({r, c});
  std::shuffle(cells.begin(), cells.end(), random);
  Navigation navigation(30, 30);
  navigation.set_goal({0, 0});
  for (double speed : {0.0, 1.0}) {
    for (size_t i = 0; i < cells.size(); ++i) {
      navigation.set_speed(cells[i], speed);
      if (i % 7 != 0) continue;
      navigation.propagate();
      expect_as_anew(navigation, static_cast<int>(i));
      if (HasFatalFailure()) return;
    }
    navigation.propagate();
    EXPECT_EQ(std::isinf(navigation.cost({29, 29})), speed == 0);
  }
}

TEST(Navigation, a_goal_that_is_walled_in_has_no_way_until_a_door_opens) {
  Navigation navigation(20, 20);
  navigation.set_goal({5, 5});
  for (int i = 3; i <= 7; ++i)
    for (const Cell& cell : {Cell{3, i}, Cell{7, i}, Cell{i, 3}, Cell{i, 7}}) navigation.set_speed(cell, 0);
  navigation.propagate();
  EXPECT_TRUE(std::isinf(navigation.cost({15, 15})));
  EXPECT_TRUE(std::isfinite(navigation.cost({4, 4})));
  EXPECT_TRUE(navigation.path({15.5, 15.5}).empty());
  navigation.set_speed({3, 5}, 1);  // the far side
  EXPECT_TRUE(navigation.path({15.5, 15.5}).empty()) << "no way is told that has not been calculated";
  navigation.propagate();
  expect_as_anew(navigation, 0);
  const auto way = navigation.path({15.5, 15.5});
  expect_passable(navigation, way, "door");
  navigation.set_speed({5, 5}, 0);
  navigation.propagate();
  EXPECT_TRUE(navigation.path({15.5, 15.5}).empty()) << "an obstacle on the goal";
}

TEST(Navigation, a_step_does_not_squeeze_between_two_obstacles_that_meet_at_a_corner) {
  Navigation navigation(10, 10);
  navigation.set_goal({0, 9});
  for (int i = 0; i < 10; ++i)
    if (i != 9) navigation.set_speed({i, i}, 0);  // a wall of corners; the only way is over its end
  navigation.propagate();
  expect_passable(navigation, navigation.path({9.5, 0.5}), "wall");
  navigation.set_speed({9, 9}, 0);
  navigation.propagate();
  EXPECT_TRUE(navigation.path({9.5, 0.5}).empty());
}

TEST(Navigation, a_slow_cell_is_gone_round_where_that_is_shorter) {
  Navigation navigation(11, 11);
  navigation.set_goal({0, 5});
  for (int c = 2; c <= 8; ++c) navigation.set_speed({5, c}, 0.1);
  navigation.propagate();
  for (const Place& place : navigation.path({10.5, 5.5})) EXPECT_EQ(navigation.speed(cell_at(place)), 1);
  for (int c = 0; c < 11; ++c) navigation.set_speed({5, c}, 0.1);
  navigation.propagate();
  expect_passable(navigation, navigation.path({10.5, 5.5}), "through, where there is no other way");
}

TEST(Navigation, a_change_behind_the_rover_costs_a_few_cells) {
  Navigation navigation(50, 51);
  navigation.set_goal({0, 25});
  const size_t all = navigation.propagate();
  EXPECT_EQ(all, 2550u);
  navigation.set_speed({47, 10}, 0);
  EXPECT_LT(navigation.propagate(), all / 20);
  navigation.set_speed({47, 10}, 0);
  EXPECT_EQ(navigation.propagate(), 0u) << "what it was is no change";
}

/// The daemon's side and the reader's: a grid, its changes, and a follower.
struct FollowedMapTest : testing::Test {
  vdisp::MapComparison stage;
  Picture grid{Pixel::int8, 51, 50}, changes{vdisp::record_spec<vdisp::MapChanges>()};
  FollowedMap map{Policy{}};
  Navigation navigation{50, 51};

  FollowedMapTest() {
    stage.check(std::vector{grid.spec()});
    grid.image().epoch = 5;
    grid.image().grid = {0.1f, 50, 25.5f, -0.5f, 0.5f, 3, 0, 0.1f, 0, 0};
    navigation.set_goal({2, 25});
  }
  /// The daemon's next frame.
  void make() {
    ++grid.image().sequence;
    changes.image().describe_like(grid.image());
    changes.image().state = vdisp::ImageState::valid;
    const vdisp::Image* const in[] = {&grid.image()};
    vdisp::Image* const out[] = {&changes.image()};
    stage.process(in, out);
  }
  Read follow() {
    const Read read = map.follow(&grid.image(), &changes.image());
    for (const Cell& cell : map.changed()) navigation.set_speed(cell, map.speed(cell));
    navigation.propagate();
    return read;
  }
  void expect_same() {
    FollowedMap other{Policy{}};
    EXPECT_EQ(other.follow(&grid.image(), &changes.image()), Read::whole) << "the first look";
    for (int r = 0; r < 50; ++r) {
      for (int c = 0; c < 51; ++c) {
        ASSERT_EQ(map.occupancy({r, c}), grid.at<int8_t>(r, c)) << r << ' ' << c;
        ASSERT_EQ(map.speed({r, c}), other.speed({r, c})) << r << ' ' << c;
        ASSERT_EQ(navigation.speed({r, c}), other.speed({r, c})) << r << ' ' << c;
      }
    }
    expect_as_anew(navigation, static_cast<int>(grid.image().sequence));
  }
  Read next() {
    make();
    const Read read = follow();
    expect_same();
    return read;
  }
};

TEST_F(FollowedMapTest, follows_lists_and_the_plan_is_as_planned_anew) {
  std::mt19937 random(8);
  EXPECT_EQ(next(), Read::whole);
  for (int frame = 0; frame < 150; ++frame) {
    for (int i = 0; i < 40; ++i)
      grid.at<int8_t>(static_cast<int>(random() % 50), static_cast<int>(random() % 51)) =
          static_cast<int8_t>(random() % 10 == 0 ? 90 : static_cast<int>(random() % 66) - 1);
    ASSERT_EQ(next(), Read::listed) << frame;
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(next(), Read::nothing);
  EXPECT_TRUE(map.changed().empty());
}

TEST_F(FollowedMapTest, the_list_alone_is_read_where_it_is_enough) {
  next();
  grid.at<int8_t>(30, 30) = 90;
  make();
  grid.at<int8_t>(10, 10) = 90;  // not in the list
  EXPECT_EQ(follow(), Read::listed);
  EXPECT_EQ(map.occupancy({30, 30}), 90);
  EXPECT_EQ(map.occupancy({10, 10}), 0);
}

TEST_F(FollowedMapTest, a_lost_update_forces_a_full_read) {
  next();
  grid.at<int8_t>(30, 30) = 90;
  make();  // never seen
  grid.at<int8_t>(10, 10) = 90;
  EXPECT_EQ(next(), Read::whole);
  EXPECT_EQ(next(), Read::nothing);
}

TEST_F(FollowedMapTest, a_lost_frame_without_changes_is_no_lost_update) {
  next();
  make();
  grid.at<int8_t>(10, 10) = 90;
  EXPECT_EQ(next(), Read::listed);
}

TEST_F(FollowedMapTest, a_new_epoch_forces_a_full_read_even_at_the_same_generation) {
  next();
  grid.image().epoch = 6;
  grid.at<int8_t>(10, 10) = 90;
  make();
  EXPECT_EQ(vdisp::record_of<vdisp::MapChanges>(changes.image())->generation, 1u) << "as in the old epoch";
  EXPECT_EQ(follow(), Read::whole);
  expect_same();
}

TEST_F(FollowedMapTest, an_overflow_forces_a_full_read) {
  next();
  grid.fill<int8_t>([](int r, int c) { return static_cast<int8_t>((r + c) % 60); });
  EXPECT_EQ(next(), Read::whole);
  grid.at<int8_t>(1, 1) = 99;
  EXPECT_EQ(next(), Read::listed);
}

TEST_F(FollowedMapTest, a_blind_frame_is_refused_and_the_next_is_read_whole) {
  next();
  grid.image().set_blind(vdisp::Reason::few_points);
  changes.image().set_blind(vdisp::Reason::few_points);
  EXPECT_EQ(follow(), Read::refused);
  EXPECT_FALSE(map.known());
  EXPECT_TRUE(map.changed().empty());
  grid.image().state = vdisp::ImageState::valid;
  EXPECT_EQ(next(), Read::whole) << "no hole in the sequence, and yet: who forgot reads all";
  EXPECT_EQ(map.follow(nullptr, nullptr), Read::refused);
  EXPECT_EQ(map.follow(&changes.image(), &grid.image()), Read::refused);
}

TEST_F(FollowedMapTest, images_of_two_frames_are_refused) {
  next();
  ++grid.image().sequence;
  EXPECT_EQ(follow(), Read::refused);
}

TEST_F(FollowedMapTest, a_grid_of_another_size_is_read_anew) {
  next();
  Picture small{Pixel::int8, 20, 10};
  small.image().describe_like(grid.image());
  ++small.image().sequence;
  ++changes.image().sequence;
  EXPECT_EQ(map.follow(&small.image(), &changes.image()), Read::whole);
  EXPECT_EQ(map.changed().size(), 200u);
}

TEST_F(FollowedMapTest, a_list_that_does_not_fit_the_grid_is_not_believed) {
  next();
  grid.at<int8_t>(1, 1) = 90;
  make();
  changes.image().row<vdisp::MapChanges>(0)->cells[0].column = 51;
  EXPECT_EQ(follow(), Read::whole);
  grid.at<int8_t>(1, 1) = 80;
  make();
  changes.image().row<vdisp::MapChanges>(0)->count = 5000;
  EXPECT_EQ(follow(), Read::whole);
  expect_same();
}

TEST_F(FollowedMapTest, a_percent_more_or_less_is_read_and_changes_no_speed) {
  grid.fill<int8_t>([](int, int) { return int8_t{3}; });
  next();
  for (int8_t value : {int8_t{0}, int8_t{9}}) {
    grid.at<int8_t>(20, 20) = value;
    EXPECT_EQ(next(), Read::listed);
    EXPECT_TRUE(map.changed().empty());
  }
}

TEST_F(FollowedMapTest, a_planner_repairs_costs_or_forgets_them_and_has_those_of_planning_anew) {
  std::mt19937 random(4);
  Planner planner({4.85, 0}, Policy{}, true);
  int repaired = 0, forgot = 0;
  for (int frame = 0; frame < 200; ++frame) {
    for (int i = 0; i < frame % 20; ++i)
      grid.at<int8_t>(static_cast<int>(random() % 50), static_cast<int>(random() % 51)) = random() % 8 ? int8_t{0} : int8_t{90};
    make();
    const Plan plan = planner.plan(grid.image(), changes.image());
    ASSERT_TRUE(plan.as_anew) << frame;
    ASSERT_EQ(plan.forgot, plan.fed > 51) << frame;
    ASSERT_EQ(plan.read, frame == 0 ? Read::whole : frame % 20 == 0 ? Read::nothing : plan.read) << frame;
    ++(plan.forgot ? forgot : repaired);
    if (plan.way.empty()) continue;
    EXPECT_EQ(cell_at(plan.way.back()), (Cell{2, 25})) << "4.75 m ahead of the camera";
    EXPECT_GT(plan.cost_m, 4.6);
  }
  EXPECT_GT(repaired, 100);
  EXPECT_GT(forgot, 0);
}

TEST_F(FollowedMapTest, a_planner_says_why_there_is_no_way) {
  Planner planner({4.85, 0}, Policy{}, false);
  const auto why = [&] {
    make();
    const Plan plan = planner.plan(grid.image(), changes.image());
    return plan.way.empty() ? std::string(plan.why) : "there is one";
  };
  EXPECT_EQ(why(), "there is one");
  for (int c = 0; c < 51; ++c) grid.at<int8_t>(20, c) = 100;
  EXPECT_EQ(why(), "all ways to the goal are blocked");
  grid.at<int8_t>(49, 25) = 100;
  EXPECT_EQ(why(), "the rover stands where it may not drive");
  grid.at<int8_t>(2, 25) = 100;
  EXPECT_EQ(why(), "the goal is no ground to drive on");
  grid.image().grid.frame = 2;
  EXPECT_NE(why().find("in a frame that this example does not know"), std::string::npos);
  EXPECT_FALSE(planner.map().known());
  grid.image().grid.frame = 0;
  grid.fill<int8_t>([](int, int) { return int8_t{0}; });
  EXPECT_EQ(why(), "there is one");
  planner.forget();
  EXPECT_FALSE(planner.map().known());
}

TEST_F(FollowedMapTest, speeds_are_the_policys) {
  grid.at<int8_t>(5, 5) = -1;
  grid.at<int8_t>(5, 6) = 64;
  grid.at<int8_t>(20, 20) = 65;
  next();
  EXPECT_EQ(map.speed({5, 5}), 0.5);
  EXPECT_NEAR(map.speed({5, 6}), 0.4, 1e-12) << "in whole tenths";
  EXPECT_EQ(map.speed({40, 40}), 1);
  EXPECT_EQ(map.speed({20, 20}), 0);
  EXPECT_NEAR(map.speed({20, 21}), 0.1, 1e-12);
  EXPECT_GT(map.speed({20, 22}), map.speed({20, 21}));
  EXPECT_LT(map.speed({20, 22}), 1);
  EXPECT_NEAR(map.speed({20, 23}), 2 / 3.0, 1e-6) << "0.3 m from it";
  EXPECT_EQ(map.speed({20, 24}), 1) << "0.4 m from it";
  FollowedMap wide{Policy{0.5, 65, 0.2, 0.3}};
  wide.follow(&grid.image(), &changes.image());
  EXPECT_EQ(wide.speed({20, 23}), 0) << "0.3 m from it";
  EXPECT_EQ(wide.speed({22, 22}), 0);
  EXPECT_NEAR(wide.speed({20, 24}), 0.5, 1e-6);
  EXPECT_NEAR(wide.speed({20, 25}), 1, 1e-6);
  EXPECT_EQ(wide.speed({20, 26}), 1);
  FollowedMap careful{Policy{0, 65, 0}};
  careful.follow(&grid.image(), &changes.image());
  EXPECT_EQ(careful.speed({5, 5}), 0);
  EXPECT_EQ(careful.speed({20, 21}), 1);
}

TEST(Ground, a_point_of_the_rover_lies_in_the_cell_that_frames_of_reference_says) {
  const vdisp::GridGeometry grid{0.1f, 50, 25.5f, -0.5f, 0.5f, 3, 0, 0.2f, 0.05f, 0};
  EXPECT_EQ(cell_at(grid_place(grid, 0.2 + 2.05, 0.05)), (Cell{29, 25})) << "2.05 m ahead of the camera";
  EXPECT_EQ(cell_at(grid_place(grid, 0.2 + 2.05, 0.05 + 1)), (Cell{29, 15})) << "1 m to the left";
  const vdisp::GridGeometry turned{0.1f, 50, 25.5f, -0.5f, 0.5f, 3, 0, 0, 0, static_cast<float>(M_PI / 2)};
  EXPECT_EQ(cell_at(grid_place(turned, 0, 2.05)), (Cell{29, 25})) << "a camera that looks to the left";
  for (const auto& g : {grid, turned}) {
    const auto [x, y] = rover_place(g, grid_place(g, 1.25, -0.75));
    EXPECT_NEAR(x, 1.25, 1e-6);
    EXPECT_NEAR(y, -0.75, 1e-6);
  }
}

}  // namespace
}  // namespace planner
