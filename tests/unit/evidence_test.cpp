// evidence_test.cpp: pixels find their cell of the map, and cells their pixels. Truth: points on a drawn floor, by geometry/frames.h.
// SPDX-License-Identifier: Apache-2.0
#include "probe/evidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/geometry/frames.h"
#include "ipc/outlet.h"

namespace vdisp {
namespace {

constexpr double pitch = 0.26, roll = 0.06, camera_height = 0.8;
const StereoView view{580, 318, 243, 0.09, 1.5};

class Evidence : public testing::Test {
 protected:
  Evidence() : disparity_({Pixel::disparity16, 0, 640, 480}), surface_({Pixel::gray8, 0, 640, 480}), grid_({Pixel::int8, 0, 51, 50}) {
    disparity_.loan().camera = {580, 318, 243, 0.09f, 1.5f, 0, 64, {}};
    GridGeometry& grid = grid_.loan().grid = {};
    grid.cell = 0.1f;
    grid.origin_row = 50;
    grid.origin_column = 25.5f;
    floor_.state = FloorState::found;
    floor_.model = FloorKind::profile;
    floor_.pitch_rad = pitch;
    floor_.roll_rad = roll;
    floor_.height_m = camera_height;
  }
  Reprojection reprojection() { return {disparity_.loan(), floor_, grid_.loan()}; }

  struct Seen {
    double u, v, d;
  };
  /// A point `above` m over the plane of the floor.
  static Seen see(double x, double ahead, double above) {
    const Point c = camera({x, camera_height - above, ahead}, pitch, roll);
    return {view.cx + view.f * c.x / c.z, view.cy + view.f * c.y / c.z, view.disparity(c.z)};
  }

  BufferOutlet disparity_, surface_, grid_;
  FloorModel floor_{};
};

// Middles of cells: the row of a point is by its ground distance, whatever its height.
TEST_F(Evidence, a_pixel_stands_in_the_cell_that_its_point_stands_in) {
  const Reprojection r = reprojection();
  ASSERT_TRUE(r.possible());
  int tried = 0;
  for (int row = 0; row < 40; ++row) {
    for (int column = 5; column < 46; ++column) {
      for (double above : {0.0, 0.2}) {
        const Seen seen = see((column + 0.5 - 25.5) * 0.1, (49.5 - row) * 0.1, above);
        if (seen.u < 0 || seen.u > 639 || seen.v < 0 || seen.v > 479) continue;
        // To whole pixels: 5 mm at 5 m.
        const auto cell = r.cell_of(static_cast<int>(std::lround(seen.u)), static_cast<int>(std::lround(seen.v)), seen.d);
        ASSERT_TRUE(cell);
        EXPECT_EQ(*cell, (MapCell{row, column}));
        ++tried;
      }
    }
  }
  EXPECT_GT(tried, 1000);
  EXPECT_FALSE(r.cell_of(320, 240, 1.5));  // at infinity
  EXPECT_FALSE(r.cell_of(320, 240, 3.0));  // 35 m
}

TEST_F(Evidence, the_plane_of_the_floor_has_the_disparity_of_its_points) {
  const Reprojection r = reprojection();
  const Point c = camera({0.3, camera_height, 2.4}, pitch, roll);
  // At whole pixels, so by the ray: the point where the ray of pixel (u, v) meets the plane.
  const int u = static_cast<int>(view.cx + view.f * c.x / c.z), v = static_cast<int>(view.cy + view.f * c.y / c.z);
  const Point ray = horizontal({(u - view.cx) / view.f, (v - view.cy) / view.f, 1}, pitch, roll);
  const auto d = r.floor_disparity(u, v);
  ASSERT_TRUE(d);
  EXPECT_NEAR(*d, view.disparity(camera_height / ray.y), 1e-4);
  EXPECT_FALSE(r.floor_disparity(u, 10));  // the horizon is at row 243 - 580 tan 0.26 = 89
}

TEST_F(Evidence, a_cell_is_seen_where_its_floor_is_also_on_a_profile) {
  floor_.profile_count = 3;  // from 0 to 0.2 m between 1 and 3 m
  floor_.profile_start_m = 1;
  floor_.profile_step_m = 1;
  floor_.profile_m[1] = 0.1f;
  floor_.profile_m[2] = 0.2f;
  const Reprojection r = reprojection();
  for (const MapCell cell : {MapCell{34, 25}, MapCell{30, 30}, MapCell{25, 18}}) {
    const double x = (cell.column + 0.5 - 25.5) * 0.1, ahead = (49.5 - cell.row) * 0.1;
    const Seen middle = see(x, ahead, (ahead - 1) * 0.1);
    const CellView at = r.view_of(cell);
    EXPECT_NEAR((at.left + at.right) / 2.0, middle.u, 2) << cell.row;
    EXPECT_NEAR((at.top + at.bottom) / 2.0, middle.v, 2) << cell.row;
    EXPECT_NEAR(at.right - at.left, 0.1 * (middle.d - view.cx_offset) / view.baseline, 1.5) << cell.row;
    EXPECT_LT(at.disparity_far, middle.d);
    EXPECT_GT(at.disparity_near, middle.d);
    EXPECT_LT(at.disparity_near - at.disparity_far, 0.1 * middle.d);
  }
}

TEST_F(Evidence, a_cell_beside_the_picture_has_no_pixels) {
  EXPECT_TRUE(reprojection().view_of({49, 25}).empty());  // at the foot of the camera
  EXPECT_TRUE(reprojection().view_of({35, 0}).empty());   // 2.5 m aside, 1.5 m ahead
  EXPECT_FALSE(reprojection().view_of({25, 25}).empty());
}

TEST_F(Evidence, pixels_are_tallied_by_surface_reason_and_depth) {
  Image &disparity = disparity_.loan(), &surface = surface_.loan();
  for (int v = 0; v < 480; ++v) {
    std::fill_n(disparity.row<int16_t>(v), 640, int16_t{20 * 16});
    std::fill_n(surface.row<uint8_t>(v), 640, static_cast<uint8_t>(Surface::floor));
  }
  disparity.row<int16_t>(100)[10] = 24 * 16;  // nearer than 21 + 3 % + 1
  disparity.row<int16_t>(100)[11] = 17 * 16;  // farther than 19 - 3 % - 1
  disparity.row<int16_t>(100)[12] = rejected(Rejected::speckle);
  surface.row<uint8_t>(100)[12] = static_cast<uint8_t>(Surface::none);
  disparity.row<int16_t>(100)[14] = 1;  // outside the view
  const Tally tally = tally_of(disparity, surface, {10, 14, 100, 102, 19, 21});
  EXPECT_EQ(tally.surfaces[static_cast<size_t>(Surface::floor)], 7);
  EXPECT_EQ(tally.surfaces[static_cast<size_t>(Surface::none)], 1);
  EXPECT_EQ(tally.rejected[static_cast<size_t>(Rejected::speckle)], 1);
  EXPECT_EQ(tally.nearer, 1);
  EXPECT_EQ(tally.farther, 1);
  EXPECT_EQ(tally.there, 5);
}

TEST_F(Evidence, points_of_a_cell_and_its_neighbours_end_at_the_borders) {
  BufferOutlet map({Pixel::count16, 0, 51, 50});
  for (int row = 0; row < 50; ++row)
    for (int column = 0; column < 51; ++column) map.loan().row<int16_t>(row)[column] = static_cast<int16_t>(100 * row + column);
  EXPECT_EQ(points_around(map.loan(), {10, 7}), 900 + 1000 + 1100 + 3 * 7);
  EXPECT_EQ(points_around(map.loan(), {0, 7}), 100 + 2 * 7);
  EXPECT_EQ(points_around(map.loan(), {49, 7}), 4800 + 4900 + 2 * 7);
}

TEST_F(Evidence, what_stands_in_a_cell_is_found_wherever_it_is_in_the_image) {
  Image& disparity = disparity_.loan();
  for (int v = 0; v < 480; ++v) std::fill_n(disparity.row<int16_t>(v), 640, rejected(Rejected::matcher));
  const MapCell cell{29, 30};
  for (double above : {0.1, 0.2, 0.3}) {  // a post in the middle of the cell
    const Seen seen = see(0.5, 2.05, above);
    disparity.row<int16_t>(static_cast<int>(seen.v))[static_cast<int>(seen.u)] = static_cast<int16_t>(std::lround(16 * seen.d));
  }
  disparity.row<int16_t>(470)[600] = 50 * 16;
  Image& surface = surface_.loan();
  for (int v = 0; v < 480; ++v) std::fill_n(surface.row<uint8_t>(v), 640, static_cast<uint8_t>(Surface::none));
  const Seen filled = see(0.5, 2.05, 0.2);
  surface.row<uint8_t>(static_cast<int>(filled.v))[static_cast<int>(filled.u)] = static_cast<uint8_t>(Surface::filled);
  const Standing standing = standing_in(cell, disparity, surface, reprojection());
  const Seen top = see(0.5, 2.05, 0.3), foot = see(0.5, 2.05, 0.1);
  EXPECT_EQ(standing.pixels, 3);
  EXPECT_EQ(standing.filled, 1);
  EXPECT_EQ(standing.top, static_cast<int>(top.v));
  EXPECT_EQ(standing.bottom, static_cast<int>(foot.v));
  EXPECT_NEAR(standing.least, std::min(top.d, foot.d), 0.04);
  EXPECT_NEAR(standing.most, std::max(top.d, foot.d), 0.04);
}

TEST_F(Evidence, nothing_is_told_without_floor_calibration_or_a_grid) {
  floor_.state = FloorState::lost;
  EXPECT_FALSE(reprojection().possible());
  floor_.state = FloorState::held;
  EXPECT_TRUE(reprojection().possible());
  floor_.pitch_rad = NAN;
  EXPECT_FALSE(reprojection().possible());
  floor_.pitch_rad = pitch;
  disparity_.loan().camera.f = 0;
  EXPECT_FALSE(reprojection().possible());
  disparity_.loan().camera.f = 580;
  grid_.loan().grid.cell = NAN;
  EXPECT_FALSE(reprojection().possible());
}

}  // namespace
}  // namespace vdisp
