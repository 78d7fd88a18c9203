// rectify_test.cpp: rectification is bilinear interpolation, the same bytes at every level, and never looks outside the raw image.
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <string_view>

#include "tests/kernels/rectify_maps.h"

namespace vdisp::kernels {
namespace {

using Kind = RectifyTable::Kind;

TEST(Rectify, is_the_same_at_every_level_for_all_maps_sizes_and_strides) {
  for (const auto& [raw_width, raw_height] : raw_sizes) {
    for (int extra : {0, 8, 13}) {
      const Raw raw(raw_width, raw_height, extra);
      std::vector<std::pair<int, int>> sizes = {{1, 1}, {5, 3}, {131, 7}};
      sizes.emplace_back(raw_width, raw_height);
      for (const auto& [width, height] : sizes) {
        for (const Map& map : maps_for(raw_width, raw_height)) {
          SCOPED_TRACE(std::string(map.name) + ", raw " + std::to_string(raw_width) + "x" + std::to_string(raw_height) + ", to " +
                       std::to_string(width) + "x" + std::to_string(height));
          Maps maps(width, height, map.source);
          const RectifyTable table = maps.table(raw.view());
          Picture<uint8_t> expected(width, height);
          plain::rectify(table, raw.view(), 0, height, expected.plane());
          ASSERT_EQ(expected.damage(), "");
          at_each_level([&](const std::string&, const Kernels& k) {
            Picture<uint8_t> got(width, height);
            k.rectify(table, raw.view(), 0, height, got.plane());
            ASSERT_EQ(expected, got);
          });
        }
      }
    }
  }
}

TEST(Rectify, large_images_are_the_same_at_every_level) {
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{640, 480}, {753, 480}, {1920, 1200}}) {
    const Raw raw(width, height, 0);
    for (const Map& map : maps_for(width, height)) {
      if (width > 1000 && std::string_view(map.name).find("lens") == std::string_view::npos) continue;
      SCOPED_TRACE(std::string(map.name) + " " + std::to_string(width));
      Maps maps(width, height, map.source);
      const RectifyTable table = maps.table(raw.view());
      Picture<uint8_t> expected(width, height);
      plain::rectify(table, raw.view(), 0, height, expected.plane());
      at_each_level([&](const std::string&, const Kernels& k) {
        Picture<uint8_t> got(width, height);
        k.rectify(table, raw.view(), 0, height, got.plane());
        ASSERT_EQ(expected, got);
      });
    }
  }
}

TEST(Rectify, is_bilinear_interpolation) {
  const Raw raw(64, 48, 0);
  Maps maps(64, 48, lens(64, 48, 0.05, 0.9, -0.1));
  const RectifyTable table = maps.table(raw.view());
  Picture<uint8_t> out(64, 48);
  plain::rectify(table, raw.view(), 0, 48, out.plane());
  const auto pixel = [&](int x, int y) { return x < 0 || y < 0 || x >= 64 || y >= 48 ? 0.0 : raw.view().row(y)[x]; };
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int u = maps.whole.at(2 * x, y), v = maps.whole.at(2 * x + 1, y);
      const double a = (maps.part.at(x, y) & 31) / 32.0, b = (maps.part.at(x, y) >> 5) / 32.0;
      const double exact =
          (1 - b) * ((1 - a) * pixel(u, v) + a * pixel(u + 1, v)) + b * ((1 - a) * pixel(u, v + 1) + a * pixel(u + 1, v + 1));
      // Half a level from the last rounding, half of 1/32 from the one before.
      ASSERT_NEAR(out.at(x, y), exact, 0.5 + 1.0 / 64 + 1e-9) << x << ',' << y;
    }
  }
}

TEST(Rectify, the_identity_gives_the_image_itself_and_white_stays_white) {
  for (int white : {0, 1}) {
    Raw raw(100, 20, 3);
    if (white) raw.set(255);
    Maps maps(100, 20, [](int x, int y) { return std::pair<double, double>{x, y}; });
    const RectifyTable table = maps.table(raw.view());
    Picture<uint8_t> out(100, 20);
    plain::rectify(table, raw.view(), 0, 20, out.plane());
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 100; ++x) ASSERT_EQ(out.at(x, y), raw.view().row(y)[x]) << x << ',' << y;
  }
}

TEST(Rectify, bands_of_rows_give_what_all_rows_give) {
  const Raw raw(150, 61, 2);
  Maps maps(150, 61, lens(150, 61, 0.1, 1.1, -0.4));
  const RectifyTable table = maps.table(raw.view());
  at_each_level([&](const std::string&, const Kernels& k) {
    Picture<uint8_t> whole(150, 61), bands(150, 61);
    k.rectify(table, raw.view(), 0, 61, whole.plane());
    for (int first : {40, 0, 13}) k.rectify(table, raw.view(), first, first == 40 ? 61 : first == 0 ? 13 : 40, bands.plane());
    ASSERT_EQ(whole, bands);
    Picture<uint8_t> few(150, 61), untouched(150, 61);
    k.rectify(table, raw.view(), 7, 9, few.plane());
    for (int y = 0; y < 61; ++y)
      for (int x = 0; x < 150; ++x) ASSERT_EQ(few.at(x, y), (y == 7 || y == 8 ? whole : untouched).at(x, y)) << x << ',' << y;
  });
}

TEST(Rectify, blocks_of_a_lens_fit_and_only_wild_maps_are_scattered) {
  const Raw raw(640, 480, 0);
  const size_t all = 80 * 480;
  const auto kinds = [&](const std::function<std::pair<double, double>(int, int)>& source) {
    Maps maps(640, 480, source);
    const RectifyTable table = maps.table(raw.view());
    EXPECT_EQ(table.count(Kind::inside) + table.count(Kind::border) + table.count(Kind::empty) + table.count(Kind::scattered), all);
    return table;
  };
  EXPECT_EQ(kinds(lens(640, 480, 0.01, 0.95, -0.2)).count(Kind::inside), all);
  const RectifyTable identity = kinds([](int x, int y) { return std::pair<double, double>{x, y}; });
  EXPECT_EQ(identity.count(Kind::border), 80u + 479u);  // the last row and the last column have nothing beyond them
  EXPECT_EQ(identity.count(Kind::scattered), 0u);
  const RectifyTable strong = kinds(lens(640, 480, 0.02, 1.4, -0.6));
  EXPECT_EQ(strong.count(Kind::scattered), 0u);
  EXPECT_GT(strong.count(Kind::empty), 0u);
  EXPECT_GT(strong.count(Kind::border), 0u);
  EXPECT_EQ(kinds([](int x, int y) { return std::pair{x + 1000.0, y + 0.0}; }).count(Kind::empty), all);
  EXPECT_GT(kinds(lens(640, 480, M_PI / 2, 1, 0)).count(Kind::scattered), all / 2);  // a block needs nine rows
}

TEST(Rectify, more_patterns_than_the_table_has_room_for_are_scattered) {
  std::minstd_rand random(1);
  const Raw raw(1600, 500, 0);
  Maps maps(1500, 400, [&](int x, int y) {
    const auto noise = static_cast<int>(random() >> 4);
    return std::pair{x + 3.0 + noise % 3, y + 3.0 + noise / 3 % 4};
  });
  const RectifyTable table = maps.table(raw.view());
  EXPECT_GE(table.count(Kind::inside), static_cast<size_t>(RectifyTable::most_patterns));
  EXPECT_GT(table.count(Kind::scattered), 1000u);
  Picture<uint8_t> expected(1500, 400);
  plain::rectify(table, raw.view(), 0, 400, expected.plane());
  at_each_level([&](const std::string&, const Kernels& k) {
    Picture<uint8_t> got(1500, 400);
    k.rectify(table, raw.view(), 0, 400, got.plane());
    ASSERT_EQ(expected, got);
  });
}

}  // namespace
}  // namespace vdisp::kernels
