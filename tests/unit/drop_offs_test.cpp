// drop_offs_test.cpp: where the ground ends, cell by cell; truth from points of planes, seen by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plane_scene.h"

namespace vdisp {
namespace {

using DropOffsTest = PlaneScene;

// What is seen of a dent of rough ground whose foot is matched a px too far off, 0.13 m here.
TEST_F(DropOffsTest, a_ditch_is_told_by_its_far_wall_only_where_that_rises_by_more_than_a_pixel_makes) {
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

TEST_F(DropOffsTest, a_ditch_is_a_drop_off_with_nothing_free_in_it_and_floor_behind) {
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
TEST_F(DropOffsTest, a_wall_that_leads_down_along_the_way_is_no_ramp_to_the_lower_ground) {
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
TEST_F(DropOffsTest, a_far_wall_that_is_sure_in_one_column_goes_on_in_the_next) {
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
TEST_F(DropOffsTest, an_edge_goes_on_between_its_parts_that_are_seen_and_not_where_floor_is_seen_behind) {
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

// A kerb of which the lower ground is matched only to the right.
TEST_F(DropOffsTest, an_edge_goes_on_to_the_side_of_what_is_seen_of_it_but_not_towards_floor_behind_its_line) {
  for (const bool floor_behind : {false, true}) {
    see([&](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), right = h.x * z;
      if (z == 0 || h.z * z < 2 || (floor_behind && right < -0.4)) return z;
      return right > 0.2 ? ground(1.4)(ray) : 0;
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    for (double right = -0.3; right < 0.8; right += 0.1) {
      int cells = 0;
      for (double ahead = 1.95; ahead < 2.4; ahead += 0.1) cells += why(ahead, right) == CellReason::drop_off;
      EXPECT_EQ(cells > 0, right > 0.15 || !floor_behind) << right << (floor_behind ? ", floor behind" : "");
    }
  }
}

// Too little of it to say which way it leads; where the floor ends says so.
TEST_F(DropOffsTest, an_edge_of_which_little_is_seen_goes_on_along_the_line_on_which_the_floor_ends) {
  for (const double lean : {-0.35, 0.0, 0.35}) {
    see([&](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), right = h.x * z;
      if (z == 0 || h.z * z < 2 + lean * right) return z;
      return right > 0.15 && right < 0.48 ? ground(1.4)(ray) : 0;
    });
    stage.reset();
    ASSERT_EQ(find(), Outcome::valid);
    map();
    for (double right = -0.6; right < 0.9; right += 0.1) {
      int cells = 0;
      for (double ahead = 1.85; ahead < 2.3; ahead += 0.1) cells += why(ahead + lean * right, right) == CellReason::drop_off;
      EXPECT_GT(cells, 0) << right << " m to the right of an edge that leans by " << lean;
    }
  }
}

// A kerb of which a box hides the middle. What is told goes on a cell behind the box, and no farther.
TEST_F(DropOffsTest, an_edge_goes_on_for_a_cell_behind_what_hides_it) {
  const Scene kerb = [](const Point& ray) {
    const double z = ground(high)(ray);
    return z == 0 || horizontal(ray, pitch).z * z < 2 ? z : ground(1.4)(ray);
  };
  see(with_wall(kerb, 1.55, 0.6, -0.35, 0.35));
  ASSERT_EQ(find(), Outcome::valid);
  map();
  const auto edge = [&](double right) {
    int cells = 0;
    for (double ahead = 1.95; ahead < 2.4; ahead += 0.1) cells += why(ahead, right) == CellReason::drop_off;
    return cells > 0;
  };
  int hidden = 0;
  for (double right = -0.4; right < 0.45; right += 0.1) hidden += edge(right);
  for (const int side : {-1, 1}) {
    EXPECT_TRUE(edge(side * 0.6)) << side;
    EXPECT_FALSE(edge(side * 0.3)) << side;
  }
  EXPECT_EQ(hidden, 2) << "of 0.45 m to each side";
}

// At each side of the box two columns of it are seen, which is less than a false match may have: 2.7 columns.
TEST_F(DropOffsTest, an_edge_seen_at_both_sides_of_what_hides_it_is_one) {
  enum class Between { box, post, level, unmatched };
  const auto cells = [&](Between between, bool at_left) {
    const auto strips = [=](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), right = h.x * z;
      const bool ends = between == Between::unmatched || between == Between::post;
      if (z == 0 || h.z * z < (ends && std::abs(right) < 0.35 ? 1.5 : 2)) return z;
      const bool lower = std::abs(right) > 0.35 && std::abs(right) < 0.55 && (at_left || right > 0);
      return lower ? ground(1.4)(ray) : std::abs(right) < 0.35 && between == Between::level ? z : 0;
    };
    const double half = between == Between::box ? 0.27 : between == Between::post ? 0.03 : 0;
    see(half > 0 ? with_wall(strips, 1.55, 0.6, -half, half) : Scene(strips));
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    map();
    int count = 0;
    for (int row = 0; row < 50; ++row)
      for (int column = 0; column < 51; ++column)
        count += ground_map[1]->at<uint8_t>(row, column) == static_cast<uint8_t>(CellReason::drop_off);
    return count;
  };
  EXPECT_GT(cells(Between::box, true), 3);
  EXPECT_EQ(cells(Between::box, false), 0) << "at one side of it";
  EXPECT_EQ(cells(Between::level, true), 0) << "floor between them";
  EXPECT_EQ(cells(Between::unmatched, true), 0) << "nothing is matched between them, and nothing stands before that";
  EXPECT_EQ(cells(Between::post, true), 0) << "a post hides one column of seven";
}

// Of a pit behind a box only the walls along the way are seen, at both sides of it: each column shows them farther off, and where they
// stand is hidden.
TEST_F(DropOffsTest, a_pit_is_told_by_its_sides_where_a_box_hides_the_rest) {
  const auto cells = [&](double deep, double half) {
    const Scene pit = [=](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), side = half / std::abs(h.x), bottom = (high + deep) / h.y;
      return z == 0 || h.z * z < 2 || std::abs(h.x * z) > half ? z : std::min(side, bottom);
    };
    see(with_wall(pit, 1.55, 0.6, -0.3, 0.3));
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    map();
    int count = 0;
    for (int row = 0; row < 50; ++row)
      for (int column = 0; column < 51; ++column)
        count += ground_map[1]->at<uint8_t>(row, column) == static_cast<uint8_t>(CellReason::drop_off);
    return count;
  };
  EXPECT_GT(cells(0.5, 0.6), 0);
  EXPECT_EQ(cells(0.05, 0.6), 0);
}

// Far away a few windows that are matched wrong are a few columns.
TEST_F(DropOffsTest, an_edge_is_at_least_as_wide_as_a_few_windows) {
  const auto edge_cells = [&](double from, double half_width) {
    see([&](const Point& ray) {
      const Point h = horizontal(ray, pitch);
      const double z = ground(high)(ray), ahead = h.z * z;
      return z > 0 && ahead > from && ahead < from + 1 && std::abs(h.x * z) < half_width ? 1.6 * z : z;
    });
    stage.reset();
    EXPECT_EQ(find(), Outcome::valid);
    map();
    int cells = 0;
    for (int row = 0; row < 50; ++row)
      for (int column = 0; column < 51; ++column)
        cells += ground_map[1]->at<uint8_t>(row, column) == static_cast<uint8_t>(CellReason::drop_off);
    return cells;
  };
  // A window is 3.8 cm wide per m.
  EXPECT_GT(edge_cells(1.8, 0.16), 0);
  EXPECT_EQ(edge_cells(3.6, 0.16), 0);
  EXPECT_GT(edge_cells(3.6, 0.4), 0);
}

TEST_F(DropOffsTest, one_column_of_what_is_lower_is_no_drop_off) {
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

}  // namespace
}  // namespace vdisp
