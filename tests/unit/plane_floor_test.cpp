// plane_floor_test.cpp: the floor as a plane and a profile, and the map with reasons; truth from points of planes, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/plane_floor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "daemon/stages/occupancy.h"
#include "daemon/stages/segments.h"
#include "daemon/stages/show_scene.h"
#include "daemon/stages/surfaces.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int width = 320, height = 240;
constexpr StereoView view{288, 160, 120, 0.09, 0};
constexpr double high = 0.8, pitch = 0.26;

/// What a ray meets: a distance along the view in m, 0 for nothing.
using Scene = std::function<double(const Point& ray)>;

/// Ground `below` m under the camera that is banked by `roll`.
Scene ground(double below, double roll = 0, double down = pitch) {
  return [=](const Point& ray) {
    const double fall = horizontal(ray, down, roll).y;
    return fall > 1e-6 ? below / fall : 0;
  };
}

/// An upright wall `ahead` m away, from the ground to `top` m over it, between two sides in m.
Scene with_wall(const Scene& scene, double ahead, double top, double left = -10, double right = 10) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, over = high - h.y * z, across = h.x * z;
    const double behind = scene(ray);
    return over > 0 && over < top && across > left && across < right && (behind == 0 || z < behind) ? z : behind;
  };
}

/// Ground that is level up to `edge` m ahead and then falls so steeply that nothing of it is seen; what stands there is seen over the edge.
Scene brow(double edge) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = h.y > 1e-6 ? high / h.y : 0;
    return h.z * z < edge ? z : 0;
  };
}

/// Level ground with a ditch from `near` to `far` m ahead, too deep to see its bottom.
Scene ditch(double near, double far) {
  const Scene flat = ground(high);
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray), ahead = h.z * z;
    return z > 0 && ahead > near && ahead < far ? far / h.z : z;
  };
}

/// Level ground, `deep` m lower from `edge` m ahead on to the right of `side`; a wall leads along the way between the two.
Scene kerb_beside(double edge, double side, double deep) {
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
Scene with_wall_from(const Scene& scene, double ahead, double bottom, double top, double half_width) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, up = high - h.y * z, behind = scene(ray);
    return up > bottom && up < top && std::abs(h.x * z) < half_width && (behind == 0 || z < behind) ? z : behind;
  };
}

struct PlaneFloorTest : testing::Test {
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

TEST_F(PlaneFloorTest, measures_pitch_roll_and_height_of_banked_ground) {
  for (double roll : {-0.17, 0.0, 0.17}) {
    stage.reset();
    see(ground(high, roll));
    ASSERT_EQ(find(), Outcome::valid) << roll;
    EXPECT_NEAR(model().pitch_rad, pitch, 0.003) << roll;
    EXPECT_NEAR(model().roll_rad, roll, 0.003);
    EXPECT_NEAR(model().height_m, high, 0.005);
    EXPECT_EQ(model().state, FloorState::found);
  }
}

TEST_F(PlaneFloorTest, a_wall_that_fills_most_of_the_view_is_not_the_floor) {
  config.mounting.height = 0.8f;
  see(with_wall(ground(high), 1.5, 2));
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().pitch_rad, pitch, 0.02);
  EXPECT_NEAR(model().height_m, high, 0.02);
}

TEST_F(PlaneFloorTest, the_ground_at_the_feet_is_the_floor_however_much_lies_lower) {
  config.mounting.height = 0.8f;
  const Scene low = ground(1.4), near = ground(high);
  see([&](const Point& ray) {
    const double z = near(ray);
    return z > 0 && horizontal({ray.x * z, ray.y * z, z}, pitch).z < 1.4 ? z : low(ray);
  });
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.06) << "of 0.36 m of it";
  map();
  EXPECT_EQ(why(1.25, 0), CellReason::floor);
  bool edge = false;
  for (double ahead = 1.35; ahead < 1.75; ahead += 0.1) edge = edge || (why(ahead, 0) == CellReason::drop_off && risk(ahead, 0) == 100);
  EXPECT_TRUE(edge) << "0.6 m down from 1.4 m on";
  for (double ahead = 1.75; ahead < 4; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead << " m: the bottom is no floor of this rover";
}

TEST_F(PlaneFloorTest, the_profile_follows_a_ramp) {
  constexpr double foot = 2, rise = 0.2;
  const Scene flat = ground(high);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double on_ramp = (high + rise * foot) / (h.y + rise * h.z), z = flat(ray);
    return on_ramp > 0 && on_ramp * h.z > foot && (z == 0 || on_ramp < z) ? on_ramp : z;
  });
  ASSERT_EQ(find(), Outcome::valid);
  const LocalFloor local(model(), view);
  const auto rises = [&](double from, double to) {
    return local.elevation(to) - local.elevation(from) + (to - from) * std::tan(model().pitch_rad - pitch);
  };
  EXPECT_NEAR(rises(2.5, 4), 0.3, 0.06);
  map();
  for (double ahead = 1.2; ahead < 4; ahead += 0.1) EXPECT_LT(risk(ahead, 0), 65) << ahead;
}

TEST_F(PlaneFloorTest, a_wall_is_an_obstacle_and_hides_what_lies_behind_it) {
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
TEST_F(PlaneFloorTest, what_stands_beyond_a_brow_is_an_obstacle_and_neither_floor_nor_a_drop_off) {
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
TEST_F(PlaneFloorTest, floor_that_ends_at_what_has_no_texture_is_free_only_up_to_half_a_window_before) {
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

TEST_F(PlaneFloorTest, a_patch_of_floor_by_itself_is_told_only_where_it_is_large) {
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

TEST_F(PlaneFloorTest, what_rises_less_than_max_height_beyond_a_brow_is_unknown) {
  see(with_wall_from(brow(2.3), 3.25, -0.5, -0.12, 0.4));  // 0.14 m of it are seen
  ASSERT_EQ(find(), Outcome::valid);
  map();
  for (double ahead = 2.45; ahead < 4.5; ahead += 0.1) EXPECT_EQ(risk(ahead, 0), -1) << ahead;
}

// Rough ground matched too far off looks like that, in a column or two of those looked at.
TEST_F(PlaneFloorTest, what_hides_its_foot_is_an_obstacle_only_where_it_is_wider_than_two_columns) {
  for (const double half : {0.028, 0.06}) {
    see(with_wall_from(brow(2.3), 3.25, -0.5, 0.1, half));
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(risk(3.25, 0) >= 65, half > 0.05) << half;
  }
}

// What is seen of a dent of rough ground whose foot is matched a px too far off, 0.13 m here.
TEST_F(PlaneFloorTest, a_ditch_is_told_by_its_far_wall_only_where_that_rises_by_more_than_a_pixel_makes) {
  for (const double far : {4.15, 4.75}) {
    see(ditch(3.5, far));  // 0.15 and 0.29 m of the wall are seen, a px makes 0.13 to 0.15 m
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    int drop_offs = 0;
    for (double ahead = 3.55; ahead < 4.5; ahead += 0.1) drop_offs += why(ahead, 0) == CellReason::drop_off;
    EXPECT_EQ(drop_offs > 0, far > 4.5) << far;
  }
}

TEST_F(PlaneFloorTest, a_ditch_is_a_drop_off_with_nothing_free_in_it_and_floor_behind) {
  for (double far : {2.95, 3.55}) {
    stage.reset();
    see(ditch(2.3, far));
    ASSERT_EQ(find(), Outcome::valid);
    map();
    EXPECT_EQ(why(2, 0), CellReason::floor);
    int edge = 0;
    for (double ahead = 2.25; ahead < 2.6; ahead += 0.1) edge += why(ahead, 0) == CellReason::drop_off && risk(ahead, 0) >= 65;
    EXPECT_GT(edge, 0) << far;
    for (double ahead = 2.45; ahead < far; ahead += 0.1) EXPECT_TRUE(risk(ahead, 0) < 0 || risk(ahead, 0) >= 65) << far << ", " << ahead;
    EXPECT_EQ(why(far + 0.4, 0), CellReason::floor) << far;
  }
}

// The wall beside shows each height between the two grounds at each distance: nothing of that is ground that falls.
TEST_F(PlaneFloorTest, a_wall_that_leads_down_along_the_way_is_no_ramp_to_the_lower_ground) {
  config.mounting.height = 0.8f;
  see(kerb_beside(1.8, -0.9, 0.6));
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.02);
  const LocalFloor local(model(), view);
  for (double ahead = 1.5; ahead < 5; ahead += 0.25) EXPECT_NEAR(local.elevation(ahead), 0, 0.06) << ahead;
  map();
  for (double ahead = 3; ahead < 5; ahead += 0.1)
    for (double right = -0.5; right < 1; right += 0.25) EXPECT_EQ(risk(ahead, right), -1) << ahead << ", " << right;
}

// The far wall of a ditch wide and then narrow: 0.28 m of it are seen, and 0.12 m, which is less than max_height and a px make.
TEST_F(PlaneFloorTest, a_far_wall_that_is_sure_in_one_column_goes_on_in_the_next) {
  const Scene flat = ground(high);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray), ahead = h.z * z, near = h.x * z < -0.2 ? 1.6 : 1.87;
    return z > 0 && ahead > near && ahead < 2.15 ? 2.15 / h.z : z;
  });
  ASSERT_EQ(find(), Outcome::valid);
  map();
  for (double right = -0.5; right < 0.6; right += 0.1) {
    int edge = 0;
    for (double ahead = 1.55; ahead < 2.1; ahead += 0.1) edge += why(ahead, right) == CellReason::drop_off;
    EXPECT_GT(edge, 0) << right;
  }
}

// A kerb of which the lower ground is matched only at both sides: all along between them the floor ends and nothing is seen behind.
TEST_F(PlaneFloorTest, an_edge_goes_on_between_its_parts_that_are_seen_and_not_where_floor_is_seen_behind) {
  for (const bool floor_behind : {false, true}) {
    const Scene flat = ground(high), low = ground(1.4);
    see([&](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = flat(ray), below = low(ray), right = h.x * z;
      if (z == 0 || h.z * z < 2 || (floor_behind && std::abs(right) < 0.25)) return z;
      return std::abs(right) > 0.5 ? below : 0;
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    const auto edge = [&](double right) {
      int cells = 0;
      for (double ahead = 1.95; ahead < 2.4; ahead += 0.1) cells += why(ahead, right) == CellReason::drop_off;
      return cells > 0;
    };
    EXPECT_TRUE(edge(-0.7)) << floor_behind;
    EXPECT_TRUE(edge(0.7)) << floor_behind;
    for (double right = -0.4; right < 0.5; right += 0.1) EXPECT_EQ(edge(right), !floor_behind) << right;
  }
}

// What the ground at the feet leans by fills most of the picture: a plane that leans with it would be 0.15 m off 2 m aside.
TEST_F(PlaneFloorTest, a_bump_at_the_feet_does_not_bank_the_ground_ahead) {
  for (const double lean : {-0.07, 0.07}) {
    const Scene bump = ground(high, lean), flat = ground(high);
    see([&](const Point& ray) {
      const double z = bump(ray);
      return z > 0 && horizontal(ray, pitch).z * z < 2.5 ? z : flat(ray);
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    EXPECT_NEAR(model().roll_rad, 0, 0.02) << lean;
    map();
    for (int row = 0; row < 50; ++row) {
      for (int column = 0; column < 51; ++column) EXPECT_LT(ground_map[0]->at<int8_t>(row, column), 65) << row << ", " << column;
    }
  }
}

// Grazing ground is hardly matched: here in a strip of which one pixel a row is looked at.
TEST_F(PlaneFloorTest, the_profile_falls_where_little_of_the_falling_ground_is_seen) {
  constexpr double edge = 2, fall = 0.18;
  const Scene flat = ground(high);
  see([&](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray);
    if (z > 0 && h.z * z < edge) return z;
    const double slope = (high - fall * edge) / (h.y - fall * h.z);
    return slope > 0 && ray.x > 0 && ray.x < 5.5 / view.f ? slope : 0;
  });
  ASSERT_EQ(find(), Outcome::valid);
  const LocalFloor local(model(), view);
  for (double ahead = 2.5; ahead < 3.6; ahead += 0.25) EXPECT_NEAR(local.elevation(ahead), -fall * (ahead - edge), 0.05) << ahead;
}

// A step that the rover climbs is floor, also where it is upright.
TEST_F(PlaneFloorTest, an_upright_step_lower_than_max_height_is_no_obstacle) {
  see(with_wall(ground(high), 2.55, 0.15, -0.4, 0.4));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_LT(risk(2.55, 0), 65);
}

TEST_F(PlaneFloorTest, one_column_of_what_is_lower_is_no_drop_off) {
  const auto with_hole = [](double half_width) {
    return [=](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), ahead = h.z * z;
      return z > 0 && ahead > 2.3 && ahead < 3.2 && std::abs(h.x * z) < half_width ? 1.6 * z : z;
    };
  };
  const auto drop_offs = [&] {
    int cells = 0;
    for (int row = 0; row < 50; ++row)
      for (int column = 0; column < 51; ++column)
        cells += ground_map[1]->at<uint8_t>(row, column) == static_cast<uint8_t>(CellReason::drop_off);
    return cells;
  };
  see(with_hole(0.045));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_EQ(drop_offs(), 0);
  see(with_hole(0.5));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  EXPECT_GT(drop_offs(), 5);
  // Something lower in the next columns too, but in a cell alone, which is no edge.
  for (const double end : {2.34, 2.38, 2.42, 2.46, 2.5}) {
    see([end](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), ahead = h.z * z, half = ahead < end ? 0.15 : 0.05;
      return z > 0 && ahead > 2.3 && ahead < 3.2 && std::abs(h.x * z) < half ? 1.6 * z : z;
    });
    ASSERT_EQ(find(), Outcome::valid);
    map();
    std::vector<int> columns;
    for (int column = 0; column < 51; ++column)
      for (int row = 0; row < 50; ++row)
        if (ground_map[1]->at<uint8_t>(row, column) == static_cast<uint8_t>(CellReason::drop_off)) columns.push_back(column);
    EXPECT_TRUE(columns.empty() || columns.front() < columns.back()) << end << ": in one column";
  }
}

TEST_F(PlaneFloorTest, the_same_object_counts_the_same_near_and_far) {
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
TEST_F(PlaneFloorTest, few_pixels_that_stand_where_no_floor_is_seen_are_an_obstacle_and_among_floor_are_none) {
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

TEST_F(PlaneFloorTest, of_what_stands_at_the_rim_of_the_picture_the_part_inside_counts) {
  // What can be matched begins at column 68: -0.65 m at 2 m.
  see(with_wall(ground(high), 2.05, 0.25, -10, -0.52));
  ASSERT_EQ(find(), Outcome::valid);
  disparity.fill<int16_t>([&](int v, int u) { return u < 68 || v % 2 ? rejected(Rejected::outside) : disparity.at<int16_t>(v, u); });
  map();
  EXPECT_GE(std::max(risk(2.05, -0.6), risk(2.15, -0.6)), 65);
}

TEST_F(PlaneFloorTest, what_hangs_higher_than_the_clearance_is_not_in_the_way) {
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

TEST_F(PlaneFloorTest, darkness_glare_and_blank_walls_are_blind_at_once_and_never_held) {
  see(ground(high));
  ASSERT_EQ(find(0), Outcome::valid);
  left.fill<uint8_t>([](int, int) { return uint8_t{3}; });
  EXPECT_EQ(find(10), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::too_dark);
  left.fill<uint8_t>([](int, int) { return uint8_t{255}; });
  EXPECT_EQ(find(20), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::too_bright);
  left.fill<uint8_t>([](int, int) { return uint8_t{100}; });
  disparity.fill<int16_t>([](int, int) { return rejected(Rejected::low_texture); });
  EXPECT_EQ(find(30), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_texture);
  disparity.fill<int16_t>([](int, int) { return rejected(Rejected::not_unique); });
  EXPECT_EQ(find(40), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_matches) << "texture, and nothing matches: blocked";
}

TEST_F(PlaneFloorTest, what_is_nearer_than_the_camera_can_see_is_blind_or_blocked_but_never_free) {
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

TEST_F(PlaneFloorTest, a_floor_out_of_sight_is_held_as_long_as_told) {
  config.floor.hold = 0.5;
  see(ground(high));
  ASSERT_EQ(find(0), Outcome::valid);
  see([](const Point&) { return 0.6; });  // something flat fills the view
  ASSERT_EQ(find(400), Outcome::valid);
  EXPECT_EQ(model().state, FloorState::held);
  EXPECT_EQ(model().reason, Reason::no_floor);
  EXPECT_NEAR(model().held_s, 0.4, 1e-6);
  EXPECT_TRUE(floor[1]->image().flags & flag_held);
  EXPECT_EQ(find(600), Outcome::invalid);
  EXPECT_EQ(reason(), Reason::no_floor);
}

/// The paper's first approach, for comparison.
struct SegmentsTest : PlaneFloorTest {
  std::vector<std::unique_ptr<Picture>> shown;
  Picture model_of_floor{record_spec<FloorModel>()};

  Outcome segment() {
    Segments segments(config);
    return run_stage(segments, {&disparity, &model_of_floor}, shown);
  }
  /// Share of the pixels of rows and columns that are obstacles.
  double blocked(int top, int bottom, int from, int to) {
    int count = 0;
    for (int v = top; v < bottom; ++v)
      for (int u = from; u < to; ++u) count += shown[1]->at<uint8_t>(v, u) != 0;
    return static_cast<double>(count) / ((bottom - top) * (to - from));
  }
  void SetUp() override {
    PlaneFloorTest::SetUp();
    config.limit.angRot = config.map.angRot = pitch;
    model_of_floor.image().set_blind(Reason::no_floor);
  }
};

TEST_F(SegmentsTest, a_wall_is_an_obstacle_and_the_ground_is_none_without_a_floor_model) {
  see(with_wall(ground(high), 2.55, 0.5, -0.4, 0.4));
  ASSERT_EQ(segment(), Outcome::valid);
  const Point foot = camera({0, high, 2.55}, pitch), top = camera({0, high - 0.5, 2.55}, pitch), side = camera({0.4, high, 2.55}, pitch);
  const int low = static_cast<int>(view.cy + view.f * foot.y / foot.z), edge = static_cast<int>(view.cy + view.f * top.y / top.z),
            half = static_cast<int>(view.f * side.x / side.z);
  EXPECT_GT(blocked(edge + 3, low - 5, 160 - half + 3, 160 + half - 3), 0.95);
  EXPECT_LT(blocked(low + 6, height, 5, width - 5), 0.02);
}

TEST_F(SegmentsTest, what_rises_by_more_than_max_height_is_an_obstacle_however_gentle_its_slope) {
  config.floor.maxSlope = 1;
  config.limit.angRot = config.map.angRot = static_cast<float>(pitch + 0.1);  // level ground seems to rise
  const Scene flat = ground(high);
  see([&](const Point& ray) { return flat(ray) < 5 ? flat(ray) : 0; });
  for (const auto& [max_height, share] : {std::pair{2.0f, 0.0}, {0.05f, 0.9}}) {
    config.limit.max_height = max_height;
    ASSERT_EQ(segment(), Outcome::valid);
    EXPECT_NEAR(blocked(height / 2, height, 0, width), share, 0.1) << max_height;
  }
}

TEST_F(SegmentsTest, with_a_pitch_from_the_floor_it_is_blind_where_there_is_none) {
  config.limit.angRot = config.map.angRot = std::nanf("");
  see(ground(high));
  EXPECT_EQ(segment(), Outcome::invalid);
  EXPECT_EQ(shown[0]->image().reason, Reason::no_pitch);
}

TEST_F(SegmentsTest, it_joins_what_hangs_together_and_drops_what_is_small) {
  see(with_wall(with_wall(ground(high), 2.5, 0.6, -0.6, -0.2), 1.8, 0.6, 0.2, 0.6));
  ASSERT_EQ(segment(), Outcome::valid);
  const auto at = [&](double right, double up, double ahead) {
    const Point c = camera({right, high - up, ahead}, pitch);
    return shown[0]->at<uint8_t>(static_cast<int>(view.cy + view.f * c.y / c.z), static_cast<int>(view.cx + view.f * c.x / c.z));
  };
  const int near = at(0.4, 0.3, 1.8), far = at(-0.4, 0.3, 2.5);
  EXPECT_NE(near, 0);
  EXPECT_NE(far, 0);
  EXPECT_NE(near, far);
  EXPECT_EQ(near, at(0.3, 0.5, 1.8));
  config.image_source.SpeckleSize = 10000;
  ASSERT_EQ(segment(), Outcome::valid);
  EXPECT_EQ(at(0.4, 0.3, 1.8), 0);
}

TEST_F(PlaneFloorTest, the_scene_shows_free_ground_obstacles_and_horizon_where_they_are_seen) {
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

/// A rover with an IMU that nods on level ground, 30 frames a second.
struct ImuTest : PlaneFloorTest {
  int frame = 0;

  /// `felt`: pitch of the rover by the accelerometer; `lean`: its roll.
  void feel(double felt, double lean = 0, double force = 9.81) {
    const double up[3] = {-std::sin(felt), std::cos(felt) * std::sin(lean), std::cos(felt) * std::cos(lean)};
    sample({force * up[0], force * up[1], force * up[2]});
  }
  void sample(const std::array<double, 3>& acceleration, double age = 0) {
    Imu& record = make_record<Imu>(imu.image());
    std::copy_n(acceleration.begin(), 3, record.acceleration);
    std::fill_n(record.rate, 3, std::nan(""));
    record.age_s = age;
    record.timestamp_ns = time_ns();
    imu.image().state = ImageState::valid;
    imu.image().reason = Reason::none;
  }
  int64_t time_ns() const { return frame * int64_t{33'000'000}; }
  static double nod(int at) { return 0.087 * std::sin(2 * M_PI * 2 * at * 0.033); }
  /// The floor as it is where the rover nods by this.
  Outcome look(double nodding) {
    see(ground(high, 0, pitch + nodding));
    return find(33 * frame++);
  }
  /// Something flat before the lens.
  Outcome look_away() {
    see([](const Point&) { return 0.6; });
    return find(33 * frame++);
  }
  void SetUp() override {
    PlaneFloorTest::SetUp();
    config.mounting.height = 0.8f;
    config.mounting.pitch = static_cast<float>(pitch);
  }
};

TEST_F(ImuTest, a_floor_out_of_sight_is_held_where_the_camera_turned_to) {
  for (bool told : {true, false}) {
    stage.reset();
    frame = 0;
    for (int i = 0; i < 3; ++i) {
      told ? feel(0) : imu.image().set_blind(Reason::no_imu);
      ASSERT_EQ(look(0), Outcome::valid);
    }
    for (int i = 1; i <= 6; ++i) {
      if (told) feel(0.02 * i);
      ASSERT_EQ(look_away(), Outcome::valid);
    }
    EXPECT_EQ(model().state, FloorState::held);
    EXPECT_NEAR(model().pitch_rad, told ? pitch + 0.12 : pitch, 0.005);
    EXPECT_NEAR(model().height_m, high, 0.01);
    EXPECT_EQ(model().imu, told ? ImuUse::used : ImuUse::none);
  }
}

TEST_F(ImuTest, with_a_camera_that_looks_aside_a_nod_of_the_rover_is_a_roll_of_the_camera) {
  config.mounting.yaw = static_cast<float>(M_PI / 2);  // to the left
  config.mounting.pitch = 0;
  config.limit.angRot = config.map.angRot = 0;
  for (int i = 0; i < 3; ++i) {
    feel(0);
    see(ground(high, 0, 0));
    ASSERT_EQ(find(33 * frame++), Outcome::valid);
  }
  feel(0.06);
  ASSERT_EQ(look_away(), Outcome::valid);
  EXPECT_NEAR(model().roll_rad, 0.06, 0.005) << "the rover's nose is at the camera's right side";
  EXPECT_NEAR(model().pitch_rad, 0, 0.005);
}

TEST_F(ImuTest, on_a_slope_gravity_is_not_the_floor_and_the_difference_is_told) {
  for (int i = 0; i < 200; ++i) {
    feel(-0.15);  // nose up, on ground that rises
    ASSERT_EQ(look(0), Outcome::valid);
  }
  EXPECT_NEAR(model().pitch_rad, pitch, 0.005) << "the floor is where the images show it";
  EXPECT_EQ(model().imu, ImuUse::used);
  EXPECT_EQ(model().gravity_differs, 1u);
  EXPECT_NEAR(model().gravity_pitch_rad, pitch - 0.15, 0.005);
  EXPECT_NEAR(model().steady_pitch_rad, pitch, 0.005);
  EXPECT_EQ(model().mounting_differs, 0u);
}

TEST_F(ImuTest, one_that_turns_the_other_way_is_ignored_until_it_agrees) {
  for (int i = 0; i < 60; ++i) {
    feel(-nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
    EXPECT_NEAR(model().pitch_rad, pitch + nod(i), 0.01) << "what the images show goes before, frame " << i;
  }
  EXPECT_EQ(model().imu, ImuUse::contradicts);
  for (int i = 60; i < 240; ++i) {
    feel(nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
  }
  EXPECT_EQ(model().imu, ImuUse::used);
}

TEST_F(ImuTest, one_that_nods_with_the_rover_is_used) {
  for (int i = 0; i < 60; ++i) {
    feel(nod(i));
    ASSERT_EQ(look(nod(i)), Outcome::valid);
    if (i > 0) {
      EXPECT_EQ(model().imu, ImuUse::used) << i;
    }
  }
}

TEST_F(ImuTest, what_is_late_or_upside_down_or_jumps_or_is_no_gravity_is_not_used_and_says_why) {
  const auto use = [&] {
    EXPECT_EQ(look(0), Outcome::valid);
    EXPECT_NEAR(model().pitch_rad, pitch, 0.005);
    return model().imu;
  };
  const auto settle = [&] {
    for (int i = 0; i < 20; ++i) {
      feel(0);
      use();
    }
    EXPECT_EQ(model().imu, ImuUse::used);
  };
  settle();
  sample({0, 0, 9.81}, 0.2);
  EXPECT_EQ(use(), ImuUse::late);
  settle();
  feel(0, M_PI);
  EXPECT_EQ(use(), ImuUse::askew) << "upside down";
  sample({0, 9.81, 0});
  EXPECT_EQ(use(), ImuUse::askew) << "other axes";
  settle();
  feel(0.5);
  EXPECT_EQ(use(), ImuUse::jumped);
  settle();
  feel(0, 0, 12);
  EXPECT_EQ(use(), ImuUse::accelerating);
  sample({0, 0, 0});
  EXPECT_EQ(use(), ImuUse::accelerating);
  settle();
  --frame;
  feel(0);
  ++frame;
  EXPECT_EQ(use(), ImuUse::used) << "the same sample again: nothing turned";
  frame += 1000;
  feel(0.1);
  EXPECT_EQ(use(), ImuUse::settling) << "after a pause it begins anew";
}

TEST_F(ImuTest, a_jump_that_lasts_is_where_it_begins_anew) {
  for (int i = 0; i < 5; ++i) {
    feel(0);
    look(0);
  }
  int ignored = 0;
  for (int i = 0; i < 40; ++i) {
    feel(0.5);
    look(0);
    ignored += model().imu == ImuUse::jumped;
  }
  EXPECT_GT(ignored, 10);
  EXPECT_EQ(model().imu, ImuUse::used);
}

TEST_F(ImuTest, rates_of_turn_carry_over_what_braking_does_to_the_accelerometer) {
  const auto turning = [&](double felt, double rate) {
    feel(felt);
    Imu& record = *imu.image().row<Imu>(0);
    record.rate[0] = record.rate[2] = 0;
    record.rate[1] = rate;  // about y, to the left: nose down is positive
  };
  const auto frames = [&](int count, bool seen, const std::function<void(int)>& tell) {
    for (int i = 0; i < count; ++i) {
      tell(i);
      ASSERT_EQ(seen ? look(0) : look_away(), Outcome::valid);
    }
  };
  frames(3, true, [&](int) { turning(0, 0); });
  frames(6, false, [&](int) { turning(0.1, 0); });  // 1 m/s^2
  EXPECT_NEAR(model().pitch_rad, pitch, 0.025) << "nothing turned";
  stage.reset();
  frames(3, true, [&](int i) { turning(0, i == 2 ? 0.6 : 0); });
  frames(6, false, [&](int i) { turning(0.0198 * (i + 1), 0.6); });
  EXPECT_NEAR(model().pitch_rad, pitch + 0.119, 0.01);
}

TEST_F(PlaneFloorTest, a_wrong_mounting_is_said_with_what_was_measured) {
  config.mounting.height = 1.6f;
  see(ground(high));
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.02);
  EXPECT_EQ(model().mounting_differs, 1u);
  config.mounting.height = 0.8f;
  stage.reset();
  ASSERT_EQ(find(), Outcome::valid);
  EXPECT_EQ(model().mounting_differs, 0u);
}

/// Half of what lies on the ground lies near enough a plane within the mounting's tolerances too: that plane must not be the floor.
TEST_F(PlaneFloorTest, a_wrong_mounting_does_not_bend_the_floor_towards_itself_whatever_was_drawn) {
  config.image_source.ndisp = 32;
  disparity.image().camera.disparities = 32;
  see(with_wall(with_wall(ground(high), 1.8, 0.35, -0.95, -0.4), 3.3, 0.55, -0.15, 1.4));
  for (const float told : {0.5f, 0.6f, 1.05f, 1.2f, 1.6f}) {
    config.mounting.height = told;
    config.mounting.pitch = static_cast<float>(pitch);
    for (uint64_t sequence = 0; sequence < 20; ++sequence) {
      stage.reset();
      disparity.image().sequence = sequence;
      ASSERT_EQ(find(), Outcome::valid) << told;
      EXPECT_NEAR(model().height_m, high, 0.02) << "told " << told << ", draws of frame " << sequence;
      EXPECT_NEAR(model().pitch_rad, pitch, 0.02) << "told " << told << ", draws of frame " << sequence;
    }
  }
}

/// Ten frames agree with [mounting]; then the rover turns to a wall, and comes so near that no floor is in view.
TEST_F(PlaneFloorTest, a_wall_that_fills_the_view_is_no_floor_where_the_mounting_is_known_to_be_right) {
  trust_mounting();
  const double steepest = config.floor.maxSlope + config.mounting.pitchTolerance;
  for (const double turned : {-0.9, -0.6, -0.3, 0.3, 0.6, 0.9})
    for (const double away : {0.7, 0.8, 0.9}) {
      see([&](const Point& ray) {
        const Point h = horizontal(ray, pitch);
        const double z = away / (h.z * std::cos(turned) + h.x * std::sin(turned)), below = ground(high)(ray);
        return z > 0 && (below == 0 || z < below) ? z : below;
      });
      for (int i = 0; i < 4; ++i) {
        ++disparity.image().sequence;
        if (find(ms += 400) != Outcome::valid) continue;
        EXPECT_LT(std::abs(model().pitch_rad - pitch), steepest) << "turned " << turned << ", " << away << " m away";
        EXPECT_LT(std::abs(model().roll_rad), steepest) << "turned " << turned << ", " << away << " m away";
        EXPECT_LT(std::abs(model().height_m - high), 0.35 * high) << "turned " << turned << ", " << away << " m away";
      }
      see(ground(high));
      ASSERT_EQ(find(ms += 400), Outcome::valid) << "back on the ground";
      EXPECT_NEAR(model().pitch_rad, pitch, 0.01);
    }
  see(with_wall(ground(high), 0.8, 3));
  ASSERT_EQ(find(ms += 600), Outcome::invalid) << "longer than hold";
  EXPECT_EQ(reason(), Reason::no_floor);
}

TEST_F(PlaneFloorTest, a_ramp_that_fills_the_view_is_a_floor_where_the_mounting_is_known_to_be_right) {
  for (const double rise : {0.17, 0.26, -0.17}) {
    stage.reset();
    trust_mounting();
    // The ramp begins a metre ahead of the camera's foot, in all that is in view.
    const double below = (high + 1.0 * std::tan(rise)) * std::cos(rise);
    see(ground(below, 0, pitch + rise));
    ASSERT_EQ(find(ms += 100), Outcome::valid) << rise;
    EXPECT_EQ(model().state, FloorState::found) << rise;
    EXPECT_NEAR(model().pitch_rad, pitch + rise, 0.02);
    EXPECT_NEAR(model().height_m, below, 0.03);
  }
}

/// A camera that was knocked: nothing of what it sees can be its floor any more, until that lasted.
TEST_F(PlaneFloorTest, a_mounting_that_was_right_is_measured_anew_after_half_a_minute_without_a_floor) {
  trust_mounting();
  see(ground(1.3));
  for (int i = 0; i < 29; ++i) EXPECT_EQ(find(ms += 1000), Outcome::invalid) << i;
  for (int i = 0; i < 10; ++i) find(ms += 1000);
  EXPECT_EQ(model().state, FloorState::found);
  EXPECT_NEAR(model().height_m, 1.3, 0.03);
  EXPECT_EQ(model().mounting_differs, 1u);
}

TEST_F(PlaneFloorTest, a_mounting_of_another_roll_is_never_trusted) {
  config.mounting.roll = 0.5f;
  config.mounting.height = 0.8f;
  config.mounting.pitch = static_cast<float>(pitch);
  see(ground(high));
  for (int i = 0; i < 30; ++i) {
    ASSERT_EQ(find(ms += 100), Outcome::valid) << i;
    EXPECT_NEAR(model().roll_rad, 0, 0.03);
  }
}

TEST_F(PlaneFloorTest, a_mounting_changed_while_it_runs_is_not_trusted_before_it_is_seen_to_be_right) {
  trust_mounting();
  config.mounting.height = 1.6f;
  ASSERT_EQ(find(ms += 100), Outcome::valid);
  EXPECT_NEAR(model().height_m, high, 0.02);
  EXPECT_EQ(model().mounting_differs, 1u);
}

}  // namespace
}  // namespace vdisp
