// paint_test.cpp: colours mean the same in every frame, and words say what a pixel holds. Truth is arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "probe/paint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ipc/outlet.h"
#include "ipc/records.h"
#include "probe/contact_sheet.h"
#include "probe/map_text.h"
#include "probe/readout.h"

namespace vdisp {
namespace {

template <class T>
void set(Image& image, int x, int y, T value) {
  image.row<T>(y)[x] = value;
}

BufferOutlet blank(Pixel pixel, uint16_t width, uint16_t height) {
  BufferOutlet outlet({pixel, 0, width, height});
  Image& image = outlet.loan();
  for (int y = 0; y < height; ++y) std::fill_n(image.row<std::byte>(y), image.spec.stride(), std::byte{});
  return outlet;
}

// The paper's rover: f 580 px, baseline 9 cm.
void give_camera(Image& image) { image.camera = {580, 320, 240, 0.09f, 0, 0, 48, {}}; }

void give_grid(Image& image) {
  image.grid = {};
  image.grid.cell = 0.1f;
  image.grid.origin_row = image.spec.height;
  image.grid.origin_column = image.spec.width / 2.0f;
  image.grid.view_left = -0.55f;
  image.grid.view_right = 0.55f;
  image.grid.min_count = 3;
}

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

TEST(Readout, disparity_gives_depth_and_side) {
  BufferOutlet outlet = blank(Pixel::disparity16, 640, 1);
  give_camera(outlet.loan());
  set<int16_t>(outlet.loan(), 436, 0, 16 * 10);  // Z = 580 * 0.09 / 10 = 5.22 m; X = 116 * 5.22 / 580 = 1.044 m
  EXPECT_EQ(read_out("disparity", outlet.loan(), 436, 0), "row 0  column 436   10.00 px  Z 5.22 m  X +1.04 m");
  outlet.loan().camera.cx_offset = 4;  // Z = 580 * 0.09 / 6
  EXPECT_EQ(read_out("disparity", outlet.loan(), 436, 0), "row 0  column 436   10.00 px  Z 8.70 m  X +1.74 m");
}

TEST(Readout, rejected_pixels_say_why) {
  BufferOutlet outlet = blank(Pixel::disparity16, 1, 1);
  set<int16_t>(outlet.loan(), 0, 0, rejected(Rejected::low_texture));
  EXPECT_EQ(read_out("disparity", outlet.loan(), 0, 0), "row 0  column 0   none: low texture");
}

TEST(Readout, without_calibration_there_are_no_metres) {
  BufferOutlet outlet = blank(Pixel::disparity16, 1, 1);
  outlet.loan().camera = {};
  set<int16_t>(outlet.loan(), 0, 0, 160);
  EXPECT_EQ(read_out("disparity", outlet.loan(), 0, 0), "row 0  column 0   10.00 px  no calibration: no metres");
}

TEST(Readout, map_cell_gives_its_place) {
  BufferOutlet outlet = blank(Pixel::count16, 51, 50);
  give_grid(outlet.loan());
  set<int16_t>(outlet.loan(), 30, 29, 7);  // x = (30.5 - 25.5) * 0.1 m, z = (50 - 29.5) * 0.1 m
  EXPECT_EQ(read_out("map", outlet.loan(), 30, 29), "row 29  column 30   7 points, obstacle  z 2.05 m  x +0.50 m  (cell of 0.10 m)");
  const auto nearest = nearest_obstacle(outlet.loan());
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->distance(), std::hypot(0.5, 2.05), 1e-6);
  EXPECT_NEAR(nearest->bearing_deg(), std::atan2(0.5, 2.05) * 180 / M_PI, 1e-4);
}

TEST(Readout, records_become_lines_and_blind_ones_their_reason) {
  BufferOutlet outlet(record_spec<FloorModel>());
  auto& floor = make_record<FloorModel>(outlet.loan());
  floor.state = FloorState::found;
  floor.pitch_rad = M_PI / 12;
  floor.height_m = NAN;
  const auto lines = record_text(outlet.loan());
  EXPECT_EQ(lines.at(0), "floor       found");
  EXPECT_EQ(lines.at(2), "pitch       15.00 deg  (0.2618 rad)");
  EXPECT_EQ(lines.at(4), "height      -");
  outlet.loan().set_blind(Reason::few_points);
  EXPECT_EQ(record_text(outlet.loan()).at(0), "blind: " + std::string(describe(Reason::few_points)));
}

TEST(Readout, tells_of_cameras_what_they_deliver_and_which_is_not_open) {
  BufferOutlet outlet(record_spec<CameraStatus>());
  auto& status = make_record<CameraStatus>(outlet.loan());
  status.cameras = 2;
  status.pairs = 90;
  status.skipped = 4;
  status.apart_ms = -0.5;
  status.view[0] = {1, 1, 94, 0, 0, 0, 5000, 6, 110, 0.25, 0};
  status.view[1] = {0, 2, 90, 3, 1, 0, std::nan(""), std::nan(""), 90, 0, 0};
  const auto lines = record_text(outlet.loan());
  EXPECT_EQ(lines.at(0), "pairs       90, 4 too many for the tree");
  EXPECT_EQ(lines.at(1), "apart       -0.50 ms");
  EXPECT_EQ(lines.at(3), "left        94 frames, 0 incomplete, 0 unpaired, 0 refused, opened 1 times");
  EXPECT_NE(lines.at(4).find("floor level 110, dark 25 %, bright 0 %, exposure 5000 us, gain 6.0 dB"), std::string::npos) << lines.at(4);
  EXPECT_EQ(lines.at(5), "right       90 frames, 3 incomplete, 1 unpaired, 0 refused, opened 2 times, not open");
}

TEST(Readout, changes_of_the_map_are_counted_and_the_first_ones_shown) {
  BufferOutlet outlet(record_spec<MapChanges>());
  auto& changes = make_record<MapChanges>(outlet.loan());
  changes.generation = 9;
  changes.previous = 8;
  changes.count = changes.changed = 14;
  changes.cells[0] = {3, 20, -1, 0};
  changes.cells[1] = {4, 5, 80, 0};
  auto lines = record_text(outlet.loan());
  ASSERT_EQ(lines.size(), 15u);
  EXPECT_EQ(lines[0], "generation  9, before 8");
  EXPECT_EQ(lines[1], "changed     14 cells, 14 listed");
  EXPECT_EQ(lines[2], "row   3  column  20  unknown");
  EXPECT_EQ(lines[3], "row   4  column   5  80 %");
  EXPECT_EQ(lines[14], "and 2 more");
  changes.whole = WholeGrid::overflow;
  changes.count = 0;
  lines = record_text(outlet.loan());
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[2], "read all    more than the list holds");
}

TEST(Readout, what_is_decided_is_said_in_words) {
  BufferOutlet decided(record_spec<Decision>()), driven(record_spec<DriveCommand>()), checked(record_spec<CrossCheck>()),
      scored(record_spec<SnowScores>());
  auto& decision = make_record<Decision>(decided.loan());
  decision.steering = Steering::turn_left;
  decision.decider = Decider::snow;
  decision.clearness = 0.25;
  EXPECT_EQ(record_text(decided.loan()).at(0), "decision    turn left");
  EXPECT_EQ(record_text(decided.loan()).at(1), "by          the classifiers (SNoW)");
  EXPECT_EQ(record_text(decided.loan()).at(2), "clearness   25 %");
  auto& command = make_record<DriveCommand>(driven.loan());
  command.speed = 0.15;
  command.slowed = 1;
  EXPECT_EQ(record_text(driven.loan()).at(0), "speed       0.150 m/s");
  EXPECT_EQ(record_text(driven.loan()).back(), "slowed      the detectors disagree, or one decided alone");
  command.slowed = 0;
  command.valid_until_ns = 7'300'000'000;
  EXPECT_EQ(record_text(driven.loan()).back(), "until       7300 ms of the monotonic clock");
  auto& check = make_record<CrossCheck>(checked.loan());
  check.snow_free = 1;
  check.corridor_m = 0.95;
  check.disagreeing_s = 1.5;
  EXPECT_EQ(record_text(checked.loan()).at(0), "map         not free, 0.95 m");
  EXPECT_EQ(record_text(checked.loan()).at(2), "they        disagree since 1.5 s");
  auto& scores = make_record<SnowScores>(scored.loan());
  scores.free_difference = -0.2;
  EXPECT_EQ(record_text(scored.loan()).at(0), "way         obstacle");
  scores.obstacle_sensitivity = 0.3;
  EXPECT_EQ(record_text(scored.loan()).at(0), "way         free");
}

TEST(Readout, the_second_detectors_pictures_tell_what_a_pixel_means) {
  BufferOutlet depths = blank(Pixel::count16, 320, 32), census = blank(Pixel::gray8, 320, 240), map = blank(Pixel::gray8, 80, 60),
               contour = blank(Pixel::gray8, 80, 1);
  depths.loan().camera = contour.loan().camera = {290, 160, 120, 0.1f, 0, 0, 32, {}};
  set<int16_t>(depths.loan(), 160, 29, 44);
  EXPECT_EQ(read_out("depth_map", depths.loan(), 160, 29), "row 29  column 160   44 pixels at 29 px  Z 1.00 m  X +0.00 m");
  set<uint8_t>(census.loan(), 5, 6, 0b10010001);
  EXPECT_EQ(read_out("census/left", census.loan(), 5, 6), "row 6  column 5   145: 100 1.0 001");
  set<uint8_t>(map.loan(), 79, 59, 49);
  EXPECT_EQ(read_out("features", map.loan(), 79, 59), "row 59  column 79   49  feature 1309489") << "figure 9";
  set<uint8_t>(contour.loan(), 7, 0, 40);
  const Painted chart = paint("features", contour.loan(), {});
  EXPECT_EQ(chart.picture.height(), 60);
  EXPECT_NE(chart.picture.row(39)[7], chart.picture.row(40)[7]);
  EXPECT_NE(read_out("features", contour.loan(), 7, 50).find("obstacle at row 40"), std::string::npos);
  EXPECT_FALSE(legend("features", contour.loan(), {}).empty());
}

class MapText : public testing::Test {
 protected:
  MapText() : outlet_(blank(Pixel::count16, 51, 50)) { give_grid(outlet_.loan()); }
  size_t count(const MapLook& look, char letter) {
    size_t n = 0;
    for (const std::string& line : map_text(outlet_.loan(), look)) n += static_cast<size_t>(std::count(line.begin(), line.end(), letter));
    return n;
  }
  BufferOutlet outlet_;
};

TEST_F(MapText, single_obstacle_survives_scaling_down_wherever_it_is) {
  for (int row = 0; row < 50; row += 7) {
    for (int column = 0; column < 51; ++column) {
      set<int16_t>(outlet_.loan(), column, row, 3);
      EXPECT_GE(count({30, 12, false, false, false}, '#'), 1u) << row << " " << column;
      set<int16_t>(outlet_.loan(), column, row, 0);
    }
  }
  EXPECT_EQ(count({30, 12, false, false, false}, '#'), 0u);
}

TEST_F(MapText, fits_80_by_24_with_four_lines_to_spare) {
  const auto lines = map_text(outlet_.loan(), {80 - 6, 24 - 4, false, false, false});
  EXPECT_LE(lines.size(), 21u);
  for (const std::string& line : lines) EXPECT_LE(line.size(), 80u);
}

TEST_F(MapText, plain_text_has_no_escape_codes_and_the_camera_below_the_middle) {
  set<int16_t>(outlet_.loan(), 25, 49, 5);
  const auto lines = map_text(outlet_.loan(), {});
  ASSERT_EQ(lines.size(), 26u);
  for (const std::string& line : lines) EXPECT_EQ(line.find('\x1b'), std::string::npos);
  EXPECT_EQ(lines.back().find('^'), 25u);
  EXPECT_EQ(lines[24].find('#'), 25u);
}

TEST_F(MapText, nearest_obstacle_is_named_with_its_side) {
  EXPECT_EQ(nearest_words(outlet_.loan()), "no obstacle in the map");
  set<int16_t>(outlet_.loan(), 5, 29, 3);  // x = -2.0 m, z = 2.05 m
  EXPECT_EQ(nearest_words(outlet_.loan()), "nearest obstacle 2.86 m away, 44 deg to the left");
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
