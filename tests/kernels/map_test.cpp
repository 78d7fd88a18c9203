// map_test.cpp: obstacles and their cells: the same at every level down to the last rounding, and as geometry/frames.h has it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/map.h"

#include <algorithm>

#include "daemon/geometry/frames.h"
#include "tests/kernels/disparities.h"

namespace vdisp::kernels {
namespace {

/// Limits by shape: those of a line, and what only other floors could give.
enum class Shape { none, everything, rising, falling, flat, hill, valley, noise };
constexpr Shape all_shapes[] = {Shape::none, Shape::everything, Shape::rising, Shape::falling,
                                Shape::flat, Shape::hill,       Shape::valley, Shape::noise};

std::vector<int16_t> limit_of(Shape shape, int columns, int height) {
  std::vector<int16_t> limit(static_cast<size_t>(columns));
  std::minstd_rand random(7);
  for (int c = 0; c < columns; ++c) {
    const int up = (c * (height + 2)) / columns - 1, middle = std::abs(2 * c - columns) * (height + 2) / columns - 1;
    int row = 0;
    switch (shape) {
      case Shape::none: row = -32768; break;
      case Shape::everything: row = 32000; break;
      case Shape::rising: row = up; break;
      case Shape::falling: row = height - up; break;
      case Shape::flat: row = height / 2; break;
      case Shape::hill: row = height - middle; break;
      case Shape::valley: row = middle; break;
      case Shape::noise: row = static_cast<int>(random() % static_cast<uint32_t>(height + 2)) - 1; break;
    }
    limit[static_cast<size_t>(c)] = static_cast<int16_t>(row);
  }
  return limit;
}

Ground ground(double f, double cx, double cy, double baseline, double cx_offset, double pitch, double roll, double cell, int rows,
              int columns) {
  return {f, cx, cy, baseline, cx_offset, std::cos(pitch), std::sin(pitch), std::cos(roll), std::sin(roll), cell, rows, columns};
}

void expect_same_cells(const Kernels& k, Picture<int16_t>& disparity, const Search& search, const std::vector<int16_t>& limit,
                       const Ground& g) {
  Picture<int16_t> expected(g.columns, g.rows), got(g.columns, g.rows);
  GroundScratch scratch(disparity.plane().width, search.columns);
  for (Picture<int16_t>* map : {&expected, &got}) fill(*map, Content::black, 0);
  plain::count_cells(disparity.view(), search, limit.data(), g, expected.plane(), scratch);
  k.count_cells(disparity.view(), search, limit.data(), g, got.plane(), scratch);
  ASSERT_EQ(expected, got);
  ASSERT_EQ(got.damage(), "");
}

TEST(MarkAbove, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : awkward_sizes)
      for (const Search& search : searches)
        for (Scene scene : all_scenes)
          for (Shape shape : all_shapes) {
            Picture<int16_t> disparity(width, height);
            Picture<uint8_t> expected(width, height), got(width, height);
            fill(disparity, scene, search, static_cast<uint32_t>(width));
            const std::vector<int16_t> limit = limit_of(shape, search.columns, height);
            plain::mark_above(disparity.view(), search, limit.data(), expected.plane());
            k.mark_above(disparity.view(), search, limit.data(), got.plane());
            ASSERT_EQ(expected, got) << width << "x" << height << " from " << search.first << " shape " << static_cast<int>(shape);
            ASSERT_EQ(got.damage(), "");
          }
  });
}

TEST(MarkAbove, marks_rows_above_the_limit_of_their_disparity) {
  const Search search{16, 17, 32};
  std::vector<int16_t> limit(32, 2);
  limit[5] = -32768;
  Picture<int16_t> disparity(40, 4);
  Picture<uint8_t> mask(40, 4);
  const auto check = [&](const Kernels& k, int d, int rows) {
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 40; ++x) disparity.at(x, y) = static_cast<int16_t>(d);
    k.mark_above(disparity.view(), search, limit.data(), mask.plane());
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 40; ++x) ASSERT_EQ(mask.at(x, y), y < rows ? 255 : 0) << "disparity " << d << " at " << x << "," << y;
  };
  for (const std::string& level : levels())
    for (const auto& [d, rows] : {std::pair{16, 0}, {17, 2}, {20, 2}, {21, 0}, {22, 2}, {47, 2}, {48, 0}, {-32003, 0}})
      check(kernels(level), d, rows);
}

TEST(Ground, a_pixel_stands_where_the_frames_of_reference_put_it) {
  const StereoView view{576.3, 321.7, 238.2, 0.0893, 1.25};
  const double pitch = 0.26, roll = 0.07, cell = 0.1;
  const Ground g = ground(view.f, view.cx, view.cy, view.baseline, view.cx_offset, pitch, roll, cell, 50, 51);
  std::minstd_rand random(3);
  int inside = 0;
  for (int i = 0; i < 100000; ++i) {
    const int u = static_cast<int>(random() % 640), v = static_cast<int>(random() % 480), d = 21 + static_cast<int>(random() % 740);
    const Point h = horizontal(view.point(u, v, d / 16.0), pitch, roll);
    const double row = 50 - 1 - std::floor(h.z / cell), column = std::floor(h.x / cell + 25.5);
    const bool in = row >= 0 && row < 50 && column >= 0 && column < 51;
    ASSERT_EQ(g.cell_of(u, v, d, 64), in ? static_cast<int>(row) * 64 + static_cast<int>(column) : -1) << u << ' ' << v << ' ' << d;
    inside += in;
  }
  EXPECT_GT(inside, 10000);
}

TEST(CountCells, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : awkward_sizes)
      for (const Search& search : searches)
        for (Scene scene : all_scenes)
          for (Shape shape : all_shapes) {
            Picture<int16_t> disparity(width, height);
            fill(disparity, scene, search, static_cast<uint32_t>(width));
            SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height) + " shape " + std::to_string(static_cast<int>(shape)));
            const double offset = (search.least - 1) / 16.0;
            expect_same_cells(k, disparity, search, limit_of(shape, search.columns, height),
                              ground(60, width / 2.0, height / 2.0, 0.1, offset, 0.3, 0, 0.1, 50, 51));
          }
  });
}

TEST(CountCells, is_the_same_for_any_camera_and_grid) {
  std::minstd_rand random(11);
  const auto between = [&](double least, double most) { return least + (most - least) * static_cast<double>(random() % 1000001) / 1e6; };
  const Search search{0, 1, 768};
  const std::vector<int16_t> limit = limit_of(Shape::everything, 768, 120);
  for (int i = 0; i < 60; ++i) {
    Picture<int16_t> disparity(160, 120);
    fill(disparity, i % 2 ? Scene::mixed : Scene::slanted, search, static_cast<uint32_t>(i));
    const double offset = between(-3, 0), roll = i % 3 ? between(-0.6, 0.6) : 0, cell = i % 5 ? between(0.02, 0.5) : 0.01;
    const Ground g = ground(between(40, 2000), between(0, 160), between(0, 120), between(0.02, 0.6), offset, between(-1.5, 1.5), roll, cell,
                            1 + static_cast<int>(random() % 300), 1 + static_cast<int>(random() % 300));
    SCOPED_TRACE(i);
    at_each_level([&](const std::string&, const Kernels& k) { expect_same_cells(k, disparity, search, limit, g); });
  }
}

TEST(CountCells, what_stands_on_a_border_between_cells_is_decided_alike) {
  // Without pitch a pixel stands 16 f / d cells ahead and 16 (u - 160) / d to the right, or half of both: often that is a whole number, and
  // rounding makes it one side or the other. f = 512 is exact in single precision too, 600 is not.
  const Search search{0, 1, 768};
  const std::vector<int16_t> limit = limit_of(Shape::everything, 768, 256);
  Picture<int16_t> disparity(321, 256);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 321; ++x) disparity.at(x, y) = static_cast<int16_t>(3 * y);
  for (const auto& [f, baseline] : {std::pair{512.0, 0.125}, {600.0, 0.1}, {599.0, 0.1}}) {
    for (double cells : {1.0, 2.0}) {
      for (double pitch : {0.0, 0.25}) {
        for (int columns : {40, 41}) {
          const Ground g = ground(f, 160, 128, baseline, 0, pitch, 0, baseline * cells, 80, columns);
          at_each_level([&](const std::string&, const Kernels& k) { expect_same_cells(k, disparity, search, limit, g); });
        }
      }
    }
  }
}

TEST(CountCells, a_count_stays_at_its_most) {
  const Search search{0, 1, 768};
  const std::vector<int16_t> limit = limit_of(Shape::everything, 768, 500);
  Picture<int16_t> disparity(640, 480), map(3, 3);
  for (int pixels : {32766, 32767, 32768, 65535, 65536, 65537, 131072, 307200}) {
    for (int i = 0; i < 640 * 480; ++i) disparity.at(i % 640, i / 640) = i < pixels ? int16_t{480} : int16_t{-32001};
    const Ground g = ground(576, 320, 240, 0.09, 0, 0, 0, 10, 3, 3);
    GroundScratch scratch(640, 768);
    const auto check = [&](const Kernels& k) {
      fill(map, Content::black, 0);
      k.count_cells(disparity.view(), search, limit.data(), g, map.plane(), scratch);
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) ASSERT_EQ(map.at(x, y), x == 1 && y == 2 ? std::min(pixels, 32767) : 0) << pixels;
    };
    check(kernels("plain"));
    at_each_level([&](const std::string&, const Kernels& k) { check(k); });
  }
}

}  // namespace
}  // namespace vdisp::kernels
