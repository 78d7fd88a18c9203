// occupancy_test.cpp: what stands, hangs or cannot be seen, cell by cell; truth from points of planes, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/occupancy.h"

#include "daemon/stages/limits_mm.h"
#include "daemon/stages/show_scene.h"
#include "tests/support/plane_scene.h"

namespace vdisp {
namespace {

using OccupancyTest = PlaneScene;

TEST_F(OccupancyTest, a_wall_is_an_obstacle_and_hides_what_lies_behind_it) {
  see(with_wall(ground(high), 2.55, 0.5, -0.4, 0.4));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_GE(risk(2.55, 0), 65);
  EXPECT_EQ(why(2.55, 0), CellReason::obstacle);
  EXPECT_EQ(why(2, 0), CellReason::floor);
  EXPECT_LE(risk(2, 0), 40);
  for (double ahead = 2.75; ahead < 4; ahead += 0.1) {
    EXPECT_EQ(risk(ahead, 0), -1) << ahead;
    EXPECT_EQ(why(ahead, 0), CellReason::occluded) << ahead;
  }
  EXPECT_EQ(why(0.5, 0), CellReason::out_of_view);
  EXPECT_EQ(why(4, 2.4), CellReason::out_of_view);
}

// Its top is 0.1 m over where the floor would go on: by its height it would be a hole, floor and floor again.
TEST_F(OccupancyTest, what_stands_beyond_a_brow_is_an_obstacle_and_neither_floor_nor_a_drop_off) {
  see(with_wall_from(brow(2.3), 3.25, -0.5, 0.1, 0.4));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_EQ(why(2, 0), CellReason::floor);
  EXPECT_GE(risk(3.25, 0), 65);
  EXPECT_EQ(why(3.25, 0), CellReason::obstacle);
  for (double ahead = 2.45; ahead < 3.1; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead;
  for (double ahead = 3.4; ahead < 4.5; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead;
}

// Half a window of it is matched by the texture of the floor before it: the sky behind a brow, the foot of a blank wall.
TEST_F(OccupancyTest, floor_that_ends_at_what_has_no_texture_is_free_only_up_to_half_a_window_before) {
  for (const auto why_not : {Rejected::low_texture, Rejected::left_right}) {
    nothing = why_not;
    see(brow(2.6));
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(why(2.25, 0), CellReason::floor);
    EXPECT_EQ(why(2.5, 0), why_not == Rejected::low_texture ? CellReason::no_texture : CellReason::floor);  // 3 rows before the end
    EXPECT_EQ(risk(2.5, 0) < 0, why_not == Rejected::low_texture);
  }
}

TEST_F(OccupancyTest, a_patch_of_floor_by_itself_is_told_only_where_it_is_large) {
  nothing = Rejected::left_right;
  for (const double half : {0.08, 0.5}) {
    const Scene near = brow(2), flat = ground(high);
    see([&](const Point& ray) {
      const double z = near(ray), behind = flat(ray);
      const Point h = horizontal(ray, pitch);
      return z == 0 && std::abs(h.x * behind) < half && std::abs(h.z * behind - 3) < half ? behind : z;
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(why(1.5, 0), CellReason::floor);
    EXPECT_EQ(why(3, 0), half < 0.1 ? CellReason::speckle : CellReason::floor);
    EXPECT_EQ(risk(3, 0) < 0, half < 0.1);
  }
}

TEST_F(OccupancyTest, what_rises_less_than_max_height_beyond_a_brow_is_unknown) {
  see(with_wall_from(brow(2.3), 3.25, -0.5, -0.12, 0.4));  // 0.14 m of it are seen
  ASSERT_EQ(find(), Outcome::valid);
  map();
  for (double ahead = 2.45; ahead < 4.5; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead;
}

// Rough ground matched too far off looks like that, in a column or two of those looked at.
TEST_F(OccupancyTest, what_hides_its_foot_is_an_obstacle_only_where_it_is_wider_than_two_columns) {
  for (const double half : {0.028, 0.06}) {
    see(with_wall_from(brow(2.3), 3.25, -0.5, 0.1, half));
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(risk(3.25, 0) >= 65, half > 0.05) << half;
  }
}

// Half a window beside an edge is seen as the floor next to it.
TEST_F(OccupancyTest, a_cell_that_shows_little_floor_is_not_free) {
  nothing = Rejected::left_right;
  for (const double side : {0.078, 0.125}) {  // the cell goes from 0.05 to 0.15
    see([&](const Point& ray) {
      const double z = ground(high)(ray);
      return horizontal(ray, pitch).x * z < side ? z : 0;
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    for (double ahead = 1.55; ahead < 2.5; ahead += 0.1) {
      EXPECT_EQ(risk(ahead, 0), 0) << ahead;
      EXPECT_EQ(risk(ahead, 0.1) >= 0, side > 0.1) << ahead;
    }
  }
}

// A window that matched rough ground a px or two too near all over makes a column of it upright, between what is matched right: from 0.12 m
// under the floor to 0.12 m over it at one distance, and nothing matched before and behind.
TEST_F(OccupancyTest, what_rises_from_below_the_floor_is_an_obstacle_only_where_it_is_wider_than_two_columns) {
  const auto dent = [](double half_width) {
    return [=](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double flat = ground(high)(ray), z = 3.05 / h.z, up = high - h.y * z;
      if (std::abs(h.x * z) >= half_width || std::abs(up) > 0.24) return flat;
      return std::abs(up) < 0.12 ? z : 0.0;
    };
  };
  for (const double half : {0.018, 0.08}) {  // two of the columns that are looked at, and seven
    see(dent(half));
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(risk(3.05, 0) >= 65, half > 0.05) << half;
  }
}

// A false match is of a window or so. 181 pixels are one and a half.
TEST_F(OccupancyTest, what_stands_alone_in_one_cell_or_in_few_pixels_stays_suspected) {
  const auto stands = [&](double half_width, double top = 0.31, double at = 3.05) {
    see(ground(high));
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    // 0.25 to 0.31 m over the floor, where nothing else is matched.
    disparity.fill<int16_t>([&](int v, int u) {
      const Point h = horizontal({(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, pitch);
      const double z = at / h.z, up = high - h.y * z, flat = ground(high)({(u - view.cx) / view.f, (v - view.cy) / view.f, 1});
      if (up > 0.25 && up < top && std::abs(h.x * z) < half_width) return static_cast<int16_t>(std::lround(16 * view.disparity(z)));
      return flat > 0 && flat * h.z < at - 0.85 ? static_cast<int16_t>(std::lround(16 * view.disparity(flat)))
                                                : rejected(Rejected::not_unique);
    });
    map();
    return risk(at, 0);
  };
  EXPECT_EQ(stands(0.006), 64) << "as suspect as a cell can be: in frame after frame it adds up";
  EXPECT_EQ(stands(0.006, 0.7), 64) << "so thin a post, and nothing else of it: 43 pixels, until it is nearer";
  EXPECT_GE(stands(0.03, 0.7), 65) << "a post";
  EXPECT_EQ(stands(0.12), 64) << "a few cells, and no more pixels than a false match has";
  EXPECT_GE(stands(0.15, 0.37), 65);
  EXPECT_GE(stands(0.35, 0.27), 65) << "130 pixels, but wider than a few windows";
  EXPECT_GE(stands(0.03, 0.31, 1.55), 65) << "the least object has more pixels there";
}

// Nearer than where the least object has so few pixels, what hides no floor is no more than a false match either. 160 pixels in two cells.
TEST_F(OccupancyTest, a_few_pixels_in_the_air_stay_suspected_where_floor_is_seen_under_them) {
  const auto hangs = [&](bool floor_behind, double first, double last) {
    see(ground(high));
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    disparity.fill<int16_t>([&](int v, int u) {
      const Point ray{(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, h = horizontal(ray, pitch);
      const double z = (u % 2 ? 1.58 : 1.62) / h.z, up = high - h.y * z, across = h.x * z, flat = ground(high)(ray);
      if (up > 0.5 && up < 0.55 && across > first && across < last) return static_cast<int16_t>(std::lround(16 * view.disparity(z)));
      const bool told = flat > 0 && (floor_behind || flat * h.z < 1.5);
      return told ? static_cast<int16_t>(std::lround(16 * view.disparity(flat))) : rejected(Rejected::not_unique);
    });
    map();
    return std::max(risk(1.55, 0), risk(1.65, 0));
  };
  EXPECT_EQ(hangs(true, -0.04, 0.04), 64);
  EXPECT_GE(hangs(false, -0.04, 0.04), 65) << "of something that is hardly matched, and hides the floor";
  EXPECT_GE(hangs(true, -0.14, 0.14), 65) << "a beam";
}

// 160 pixels over max_height, fewer than a window and a half; to each side of it floor is seen behind. In the middle of a column it hides
// six tenths of a cell behind, between two columns a third of each.
TEST_F(OccupancyTest, a_low_narrow_post_stands_where_floor_is_seen_beside_it) {
  for (const double middle : {0.0, 0.05}) {
    for (const bool stands : {true, false}) {
      see(ground(high));
      stage.reset();
      ASSERT_EQ(find(), Outcome::valid);
      see([&](const Point& ray) {
        const Point h = horizontal(ray, pitch);
        const double near = ground(high)(ray), z = (std::fmod(ray.x * 144 + 1000, 1) < 0.5 ? 1.58 : 1.62) / h.z, up = high - h.y * z;
        const bool post = (stands ? up > 0 && up < 0.28 : up > 0.5 && up < 0.58) && std::abs(h.x * z - middle) < 0.03;
        return post ? z : near;
      });
      map();
      const int most = std::max({risk(1.55, 0), risk(1.65, 0), risk(1.55, 0.1), risk(1.65, 0.1)});
      EXPECT_EQ(most >= 65, stands) << middle << ": " << most;
    }
  }
}

// Columns 68 on can be matched: of the cell that has 68 and 69 at 3 m a part is out of view, of that of 150 and 151 none is.
TEST_F(OccupancyTest, what_stands_alone_at_the_rim_of_the_view_may_be_part_of_something_larger) {
  const auto stands = [&](int first, double top) {
    see(ground(high));
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    double right = 0;
    disparity.fill<int16_t>([&](int v, int u) {
      const Point h = horizontal({(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, pitch);
      const double z = 3.05 / h.z, up = high - h.y * z, flat = ground(high)({(u - view.cx) / view.f, (v - view.cy) / view.f, 1});
      if (up > 0.25 && up < top && u >= first && u < first + 2) {
        right = h.x * z;
        return static_cast<int16_t>(std::lround(16 * view.disparity(z)));
      }
      return flat > 0 && flat * h.z < 2.2 ? static_cast<int16_t>(std::lround(16 * view.disparity(flat))) : rejected(Rejected::not_unique);
    });
    map();
    return risk(3.05, right);
  };
  EXPECT_GE(stands(68, 0.27), 65);
  EXPECT_EQ(stands(150, 0.28), 64);
}

// To the nearest mm, as heights are; three quarters of 57.8 mm are 43.35.
TEST(LimitsMm, all_stages_have_the_limits_of_height_to_the_nearest_mm) {
  Config config;
  config.limit.max_height = 0.0578f;
  config.limit.clearance = 2.0497f;
  const LimitsMm limits(config);
  EXPECT_EQ(limits.step, 58);
  EXPECT_EQ(limits.clearance, 2050);
  EXPECT_EQ(limits.hole, 43);
}

// A step that the rover climbs is floor, also where it is upright.
TEST_F(OccupancyTest, an_upright_step_lower_than_max_height_is_no_obstacle) {
  see(with_wall(ground(high), 2.55, 0.15, -0.4, 0.4));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_LT(risk(2.55, 0), 65);
}

TEST_F(OccupancyTest, the_same_object_counts_the_same_near_and_far) {
  std::vector<int> risks;
  for (double ahead : {1.55, 3.55}) {
    stage.reset();
    see(with_wall(ground(high), ahead, 0.3, -0.15, 0.15));
    ASSERT_EQ(find(), Outcome::valid);
    map();
    risks.push_back(std::max(risk(ahead, 0), risk(ahead + 0.1, 0)));
  }
  EXPECT_GE(risks[0], 90);
  EXPECT_NEAR(risks[0], risks[1], 10);
}

// A wall of which one pixel in sixteen is matched, and as many false ones over ground that is seen.
TEST_F(OccupancyTest, few_pixels_that_stand_where_no_floor_is_seen_are_an_obstacle_and_among_floor_are_none) {
  see(with_wall(ground(high), 2.505, 0.5, -0.3, 0.3));
  ASSERT_EQ(find(), Outcome::valid);
  const auto on_wall = [](double z) { return std::abs(z - 2.505) < 0.05; };
  disparity.fill<int16_t>([&](int v, int u) {
    const Point ray{(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, h = horizontal(ray, pitch);
    const double z = with_wall(ground(high), 2.505, 0.5, -0.3, 0.3)(ray), ahead = h.z * z, up = high - h.y * z;
    const bool told = v % 4 == 0 && u % 4 == 0;
    if (on_wall(ahead) && up > 0.02 && !told) return rejected(Rejected::not_unique);
    // 1.55 m ahead, as if something stood there 0.3 m high.
    const bool false_match = told && std::abs(ahead - 1.55) < 0.05 && std::abs(h.x * z) < 0.5;
    return static_cast<int16_t>(z > 0 ? std::lround(16 * view.disparity(false_match ? 0.75 * z : z)) : rejected(Rejected::low_texture));
  });
  map();
  EXPECT_GE(risk(2.55, 0), 65);
  EXPECT_LT(risk(1.55, 0), 35);
  EXPECT_LT(risk(1.15, 0), 65);
}

TEST_F(OccupancyTest, of_what_stands_at_the_rim_of_the_picture_the_part_inside_counts) {
  // What can be matched begins at column 68: -0.65 m at 2 m.
  see(with_wall(ground(high), 2.05, 0.25, -10, -0.52));
  ASSERT_EQ(find(), Outcome::valid);
  disparity.fill<int16_t>([&](int v, int u) { return u < 68 || v % 2 ? rejected(Rejected::outside) : disparity.at<int16_t>(v, u); });
  map();
  EXPECT_GE(std::max(risk(2.05, -0.6), risk(2.15, -0.6)), 65);
}

TEST_F(OccupancyTest, what_hangs_higher_than_the_clearance_is_not_in_the_way) {
  config.limit.clearance = 1;
  const Scene flat = ground(high);
  see([&](const Point& ray) {  // a beam 1.2 to 1.5 m over the ground, 2.55 m ahead
    const Point h = horizontal(ray, pitch);
    const double z = 2.55 / h.z, up = high - h.y * z;
    return up > 1.2 && up < 1.5 ? z : flat(ray);
  });
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_LT(risk(2.55, 0), 65);
}

TEST_F(OccupancyTest, what_is_nearer_than_the_camera_can_see_is_blind_or_blocked_but_never_free) {
  // Nothing can be matched: each pixel's true disparity lies beyond the search. At first, and after a floor was found.
  const auto near = [&] { disparity.fill<int16_t>([](int, int) { return rejected(Rejected::not_unique); }); };
  near();
  EXPECT_EQ(find(0), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_matches);
  see(ground(high));
  ASSERT_EQ(find(33), Outcome::valid);
  near();
  EXPECT_EQ(find(66), Outcome::invalid) << "and no floor is held";
  // A strip of floor is left at the side: what the near thing hides is not free.
  const Scene flat = ground(high);
  see([&](const Point& ray) { return ray.x > -0.25 ? 0.2 : flat(ray); });
  if (find(99) != Outcome::valid) return;
  map();
  for (double ahead = 0.35; ahead < 5; ahead += 0.1)
    for (double right = -0.2 * ahead; right < 2.5; right += 0.1)
      EXPECT_FALSE(risk(ahead, right) >= 0 && risk(ahead, right) <= 40) << ahead << " " << right;
}

TEST_F(OccupancyTest, the_scene_shows_free_ground_obstacles_and_horizon_where_they_are_seen) {
  see(with_wall(ground(high), 2.55, 0.5, -0.4, 0.4));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  const auto show = [&] {
    ShowScene scene(config);
    std::vector<std::unique_ptr<Picture>> shown;
    EXPECT_EQ(run_stage(scene, {&left, over[1].get(), ground_map[0].get(), floor[1].get()}, shown), Outcome::valid);
    return std::move(shown.at(0));
  };
  left.image().camera = over[1]->image().camera;
  auto picture = show();
  const auto at = [&](double right, double up, double ahead) {  // pixel of a place over the ground
    const Point c = camera({right, high - up, ahead}, pitch);
    const int u = static_cast<int>(std::lround(view.cx + view.f * c.x / c.z)),
              v = static_cast<int>(std::lround(view.cy + view.f * c.y / c.z));
    return &picture->at<uint8_t>(v, 3 * u);
  };
  const auto* free = at(0.25, 0, 1.45);
  EXPECT_GT(free[1], free[0] + 20) << "green";
  const auto* wall = at(0.1, 0.4, 2.55);
  EXPECT_GT(wall[0], wall[1] + 20) << "red";
  const auto* hidden = at(0.1, 0, 2.95);
  EXPECT_GE(hidden[0] + 5, hidden[1]) << "behind the wall nothing is free";
  const auto* horizon = &picture->at<uint8_t>(static_cast<int>(std::floor(model().b + 0.5)), 3 * 40);
  EXPECT_GT(horizon[0], horizon[2] + 50) << "yellow";
  floor[1]->image().flags |= flag_held;
  picture = show();
  EXPECT_EQ(picture->at<uint8_t>(static_cast<int>(std::floor(model().b + 0.5)), 3 * 18), 100) << "a held floor has broken lines";
}

}  // namespace
}  // namespace vdisp
