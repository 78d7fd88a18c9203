// paint_test.cpp: colours mean the same in every frame. Truth is arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "probe/paint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ipc/records.h"
#include "probe/contact_sheet.h"
#include "probe/map_text.h"
#include "probe/readout.h"
#include "tests/unit/painted.h"

namespace vdisp {
namespace {

TEST(Paint, same_disparity_has_the_same_colour_whatever_else_is_in_the_frame) {
  BufferOutlet near = blank(Pixel::disparity16, 4, 1), far = blank(Pixel::disparity16, 4, 1);
  for (BufferOutlet* outlet : {&near, &far}) {
    give_camera(outlet->loan());
    set<int16_t>(outlet->loan(), 0, 0, 20 * 16);
  }
  set<int16_t>(near.loan(), 1, 0, 47 * 16);
  set<int16_t>(far.loan(), 1, 0, 16);
  const Painted a = paint("disparity", near.loan(), {}), b = paint("disparity", far.loan(), {});
  EXPECT_EQ(a.picture.row(0)[0], b.picture.row(0)[0]);
  EXPECT_NE(a.picture.row(0)[1], b.picture.row(0)[1]);
}

TEST(Paint, disparity_scale_spans_the_search_range) {
  BufferOutlet outlet = blank(Pixel::disparity16, 3, 1);
  Image& image = outlet.loan();
  give_camera(image);
  image.camera.min_disparity = -8;
  set<int16_t>(image, 0, 0, -8 * 16);
  set<int16_t>(image, 1, 0, 40 * 16);
  set<int16_t>(image, 2, 0, 16 * 16);
  const Painted painted = paint("disparity", image, {});
  EXPECT_EQ(painted.picture.row(0)[0], colour_of(Palette::turbo, 0));
  EXPECT_EQ(painted.picture.row(0)[1], colour_of(Palette::turbo, 1));
  EXPECT_EQ(painted.picture.row(0)[2], colour_of(Palette::turbo, 0.5));
}

TEST(Paint, each_reason_of_rejection_has_a_muted_colour_of_its_own) {
  for (uint8_t a = 1; a <= static_cast<uint8_t>(Rejected::infinity); ++a) {
    const Colour colour = rejected_colour(a);
    EXPECT_LT(std::max({colour.r, colour.g, colour.b}), 100) << "reason " << int{a};
    for (uint8_t b = 1; b < a; ++b) EXPECT_NE(colour, rejected_colour(b)) << int{a} << " and " << int{b};
    for (int i = 0; i <= 1000; ++i) EXPECT_NE(colour, colour_of(Palette::turbo, i / 1000.0));
  }
}

int apart(Colour a, Colour b) { return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b); }

TEST(Paint, each_reason_of_a_cell_has_a_colour_that_can_be_told_from_all_others) {
  const auto colour = [](CellReason why) { return reason_colour(static_cast<uint8_t>(why)); };
  for (uint8_t a = 0; a <= cell_reasons; ++a)
    for (uint8_t b = 0; b < a; ++b) EXPECT_GE(apart(reason_colour(a), reason_colour(b)), 30) << int{a} << " and " << int{b};
  EXPECT_GT(colour(CellReason::floor).g, 1.5 * colour(CellReason::floor).r);
  EXPECT_GT(colour(CellReason::obstacle).r, 2 * colour(CellReason::obstacle).g);
  EXPECT_GT(colour(CellReason::overhang).b, 2 * colour(CellReason::overhang).r);
  EXPECT_GT(std::min(colour(CellReason::drop_off).r, colour(CellReason::drop_off).b), 2 * colour(CellReason::drop_off).g);
  // What is unknown is grey or brown: hardly a colour, or the red of a brown, and never the blue, green or magenta of what is known.
  for (auto code = static_cast<uint8_t>(CellReason::too_near); code <= static_cast<uint8_t>(CellReason::rejected); ++code) {
    const Colour c = reason_colour(code);
    EXPECT_LE(c.g, c.r + 4) << int{code};
    EXPECT_LE(c.b, c.r + 12) << int{code};
    EXPECT_LE(c.r, c.g + 50) << int{code};
  }
  // What is remembered has the colour of what was seen, darker.
  EXPECT_GT(colour(CellReason::remembered_floor).g, 1.2 * colour(CellReason::remembered_floor).r);
  EXPECT_LT(colour(CellReason::remembered_floor).g, 0.7 * colour(CellReason::floor).g);
  EXPECT_GT(colour(CellReason::remembered_obstacle).r, 2 * colour(CellReason::remembered_obstacle).g);
  EXPECT_LT(colour(CellReason::remembered_obstacle).r, 0.8 * colour(CellReason::obstacle).r);
}

TEST(Paint, reasons_are_a_plan_with_a_legend_of_those_that_are_there) {
  BufferOutlet outlet = blank(Pixel::gray8, 51, 50);
  Image& image = outlet.loan();
  give_grid(image);
  for (int x = 0; x < 51; ++x)
    for (int y = 0; y < 25; ++y) set<uint8_t>(image, x, y, static_cast<uint8_t>(CellReason::floor));
  set<uint8_t>(image, 30, 10, static_cast<uint8_t>(CellReason::drop_off));
  const Painted painted = paint("reason", image, {});
  EXPECT_EQ(painted.cell, 12);
  EXPECT_EQ(painted.picture.row(10 * 12 + 4)[30 * 12 + 4], reason_colour(static_cast<uint8_t>(CellReason::drop_off)));
  const auto items = legend("reason", image, {});
  ASSERT_EQ(items.size(), 3u);
  EXPECT_EQ(items[0].to, "out of view 50%");
  EXPECT_EQ(items[1].to, "floor 50%");
  EXPECT_EQ(items[2].to, "drop-off <1%");
  EXPECT_EQ(items[2].colours.at(0), reason_colour(static_cast<uint8_t>(CellReason::drop_off)));
  EXPECT_EQ(read_out("reason", image, 30, 10), "row 10  column 30   drop-off  z 3.95 m  x +0.50 m  (cell of 0.10 m)");
}

TEST(Paint, true_cells_are_a_plan_in_the_colours_of_reasons_with_words) {
  BufferOutlet outlet = blank(Pixel::gray8, 51, 50);
  Image& image = outlet.loan();
  give_grid(image);
  set<uint8_t>(image, 30, 10, static_cast<uint8_t>(TruthCell::obstacle));
  const Painted painted = paint("truth/map_cells", image, {});
  EXPECT_EQ(painted.cell, 12);
  EXPECT_EQ(painted.picture.row(10 * 12 + 4)[30 * 12 + 4], reason_colour(static_cast<uint8_t>(CellReason::obstacle)));
  const auto items = legend("truth/map_cells", image, {});
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[1].to, "obstacle <1%");
  EXPECT_EQ(read_out("truth/map_cells", image, 30, 10), "row 10  column 30   obstacle  z 3.95 m  x +0.50 m  (cell of 0.10 m)");
  for (uint8_t a = 0; a < 7; ++a)
    for (uint8_t b = 0; b < a; ++b) EXPECT_GE(apart(true_cell_colour(a), true_cell_colour(b)), 30) << int{a} << " and " << int{b};
}

TEST(Paint, surfaces_have_the_colours_of_the_cells_they_make) {
  BufferOutlet outlet = blank(Pixel::gray8, 5, 1);
  for (uint8_t code = 0; code < 5; ++code) set<uint8_t>(outlet.loan(), code, 0, code);
  const Painted painted = paint("surface", outlet.loan(), {});
  const auto cell = [](CellReason why) { return reason_colour(static_cast<uint8_t>(why)); };
  const Colour* row = painted.picture.row(0);
  EXPECT_EQ(row[1], cell(CellReason::floor));
  EXPECT_EQ(row[2], cell(CellReason::obstacle));
  EXPECT_EQ(row[3], cell(CellReason::overhang));
  EXPECT_EQ(row[4], cell(CellReason::drop_off));
  const auto items = legend("surface", outlet.loan(), {});
  ASSERT_EQ(items.size(), 5u);
  EXPECT_EQ(items[4].to, "below the floor 20%");
  EXPECT_EQ(read_out("surface", outlet.loan(), 3, 0), "row 0  column 3   overhang");
  EXPECT_EQ(read_out("left", outlet.loan(), 3, 0), "row 0  column 3   3");
}

TEST(Paint, occupancy_jumps_where_a_cell_becomes_an_obstacle_and_is_grey_where_nothing_is_known) {
  const Colour unknown = occupancy_colour(-1), free = occupancy_colour(0);
  EXPECT_LT(std::abs(unknown.r - unknown.b), 16);
  EXPECT_GT(free.g, 2 * free.r);
  for (int percent = 1; percent <= 100; ++percent) {
    const int step = apart(occupancy_colour(static_cast<int8_t>(percent)), occupancy_colour(static_cast<int8_t>(percent - 1)));
    if (percent == occupied_from)
      EXPECT_GT(step, 90);
    else
      EXPECT_LT(step, 12) << percent;
  }
  BufferOutlet outlet = blank(Pixel::int8, 51, 50);
  give_grid(outlet.loan());
  set<int8_t>(outlet.loan(), 30, 29, 80);
  EXPECT_EQ(read_out("occupancy", outlet.loan(), 30, 29), "row 29  column 30   80 % occupied  z 2.05 m  x +0.50 m  (cell of 0.10 m)");
  const auto items = legend("occupancy", outlet.loan(), {});
  ASSERT_EQ(items.size(), 4u) << "free, suspected, obstacle, unknown";
  EXPECT_EQ(items[1].from, "suspected 41");
  EXPECT_EQ(items[1].to, "64 %");
}

TEST(Paint, more_votes_are_never_darker_and_one_vote_is_visible) {
  BufferOutlet outlet = blank(Pixel::count16, 600, 1);
  for (int16_t n = 0; n < 600; ++n) set<int16_t>(outlet.loan(), n, 0, n);
  PaintStyle style;
  style.palette = Palette::viridis;
  const Painted painted = paint("vdisparity", outlet.loan(), style);
  const auto light = [&](int n) {
    const Colour c = painted.picture.row(0)[n];
    return 3 * c.r + 6 * c.g + c.b;
  };
  EXPECT_GT(light(1), light(0) + 100);
  for (int n = 1; n < 600; ++n) EXPECT_GE(light(n), light(n - 1) - 10) << n;  // 10: one level, from rounding
}

TEST(Paint, map_cells_are_squares_that_fit_the_room_and_obstacles_are_told_from_fewer_points) {
  BufferOutlet outlet = blank(Pixel::count16, 51, 50);
  Image& image = outlet.loan();
  give_grid(image);
  set<int16_t>(image, 25, 20, 3);
  set<int16_t>(image, 26, 21, 2);
  PaintStyle style;
  style.map_room_width = 500;
  style.map_room_height = 520;
  const Painted painted = paint("map", image, style);
  EXPECT_EQ(painted.cell, 9);
  EXPECT_EQ(painted.picture.width(), 51 * 9);
  EXPECT_EQ(painted.picture.height(), 50 * 9);
  const Colour obstacle = painted.picture.row(20 * 9 + 4)[25 * 9 + 2], few = painted.picture.row(21 * 9 + 4)[26 * 9 + 2];
  EXPECT_GT(obstacle.r, 200);
  EXPECT_LT(few.r, 130);
}

TEST(Paint, a_line_below_the_picture_is_drawn_there) {
  BufferOutlet outlet = blank(Pixel::line16, 100, 1);
  for (int x = 0; x < 100; ++x) set<int16_t>(outlet.loan(), x, 0, x < 50 ? int16_t{110} : line_none);
  PaintStyle style;
  style.picture_rows = 100;
  const Painted painted = paint("floor", outlet.loan(), style);
  EXPECT_EQ(painted.picture.height(), 120);
  EXPECT_EQ(painted.picture.row(110)[20], colours::warning);
  EXPECT_NE(painted.picture.row(110)[70], colours::warning);
}

TEST(Paint, neighbouring_segments_are_told_apart_and_none_is_as_dark_as_nothing) {
  BufferOutlet outlet = blank(Pixel::gray8, 4, 1);
  for (int x = 0; x < 4; ++x) set<uint8_t>(outlet.loan(), x, 0, static_cast<uint8_t>(x));
  const Painted painted = paint("segments", outlet.loan(), {});
  const Colour* row = painted.picture.row(0);
  for (int x = 1; x < 4; ++x) {
    EXPECT_NE(row[x], row[0]);
    EXPECT_NE(row[x], row[x - 1]);
    EXPECT_GT(row[x].r + row[x].g + row[x].b, row[0].r + row[0].g + row[0].b + 100);
  }
}

TEST(Paint, every_kind_of_picture_can_be_painted_at_one_pixel) {
  for (Pixel pixel :
       {Pixel::gray8, Pixel::mask8, Pixel::rgb8, Pixel::disparity16, Pixel::count16, Pixel::height16, Pixel::int8, Pixel::line16}) {
    BufferOutlet outlet = blank(pixel, 1, 1);
    for (const char* topic : {"x", "map", "truth/object", "reason", "surface"})
      EXPECT_GT(portrait(topic, outlet.loan(), {}).width(), 0) << name(pixel);
    EXPECT_FALSE(read_out("x", outlet.loan(), 0, 0).empty()) << name(pixel);
    EXPECT_TRUE(read_out("x", outlet.loan(), 1, 0).empty()) << name(pixel);
    EXPECT_TRUE(read_out("x", outlet.loan(), 0, -1).empty()) << name(pixel);
  }
}

TEST(Paint, geometry_that_makes_no_sense_does_no_harm) {
  BufferOutlet outlet = blank(Pixel::count16, 51, 50);
  Image& image = outlet.loan();
  for (float bad : {0.0f, -1.0f, 1e30f, NAN, INFINITY}) {
    image.grid = {bad, bad, bad, bad, bad, 0, 0, bad, bad, bad};
    EXPECT_GT(portrait("map", image, {}).width(), 0);
    EXPECT_FALSE(map_text(image, {40, 20, true, true, false}).empty());
    EXPECT_FALSE(map_text(image, {}).empty());
  }
  // Each number may be one, and what is made of them none: a cell of nothing, a rover at the end of the world, ten thousand rings.
  for (float cell : {1e-38f, 1e-3f, 1e3f}) {
    for (float pose : {0.0f, 1e8f, 3e38f, NAN}) {
      image.grid = {cell, 1e5f, -1e5f, -1e3f, 1e3f, 1, grid_of_odometry, pose, -pose, pose};
      EXPECT_GT(portrait("fused", image, {}).width(), 0);
      EXPECT_FALSE(map_text(image, {}).empty());
    }
  }
  BufferOutlet disparity = blank(Pixel::disparity16, 4, 4);
  disparity.loan().camera = {NAN, NAN, NAN, NAN, NAN, INT32_MIN / 64, -5, {}};
  EXPECT_GT(portrait("disparity", disparity.loan(), {}).width(), 0);
}

TEST(Paint, legend_tells_the_share_of_each_reason) {
  BufferOutlet outlet = blank(Pixel::disparity16, 4, 1);
  set<int16_t>(outlet.loan(), 0, 0, rejected(Rejected::speckle));
  const auto items = legend("disparity", outlet.loan(), {});
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[1].to, "speckle 25%");
  EXPECT_EQ(items[1].colours.at(0), rejected_colour(4));
}

TEST(ContactSheet, has_a_tile_for_each_stage) {
  BufferOutlet a = blank(Pixel::gray8, 64, 48), b = blank(Pixel::count16, 51, 50);
  b.loan().set_blind(Reason::few_points);
  std::vector<SheetEntry> entries(5, SheetEntry{"left", &a.loan()});
  const Picture five = contact_sheet(entries, 48);
  entries.resize(4);
  entries[3] = {"map", &b.loan()};
  const Picture four = contact_sheet(entries, 48);
  EXPECT_EQ(five.width(), four.width());
  EXPECT_GT(five.height(), four.height() + 200);
}

TEST(Picture, scaling_keeps_single_pixels_sharp_and_averages_when_shrinking) {
  Picture two(2, 1), wide(20, 10), one(1, 1);
  two.row(0)[0] = {200, 0, 0};
  two.row(0)[1] = {100, 100, 0};
  wide.draw(two, {0, 0, 20, 10});
  EXPECT_EQ(wide.row(9)[9], (Colour{200, 0, 0}));
  EXPECT_EQ(wide.row(0)[10], (Colour{100, 100, 0}));
  one.draw(two, {0, 0, 1, 1});
  EXPECT_EQ(one.row(0)[0], (Colour{150, 50, 0}));
}

TEST(Picture, drawing_outside_is_clipped) {
  Picture picture(10, 10, {1, 2, 3});
  picture.fill({-5, -5, 8, 8}, {9, 9, 9});
  picture.text(-3, -3, "W\xff", {255, 255, 255}, 3);
  picture.line(-1e4, -50, 1e4, 50, {7, 7, 7});
  for (const double far : {1e7, 7e47, -1e300}) picture.line(far, far, far + 5, far, {8, 8, 8});
  picture.draw(Picture(3, 3), {-1, 8, 30, 30});
  EXPECT_EQ(fitted(640, 480, {0, 0, 100, 100}).height, 75);
}

}  // namespace
}  // namespace vdisp
