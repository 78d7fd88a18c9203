// readout_test.cpp: words say what a pixel, a record and a map hold.
// SPDX-License-Identifier: Apache-2.0
#include "probe/readout.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ipc/records.h"
#include "probe/map_text.h"
#include "probe/paint.h"
#include "tests/unit/painted.h"

namespace vdisp {
namespace {

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

}  // namespace
}  // namespace vdisp
