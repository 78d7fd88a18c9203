// rows_test.cpp: shear, mirror, texture and the choice between hypotheses are the same at every level, and what arithmetic says.
// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

constexpr int widths[] = {1, 2, 7, 16, 31, 64, 65, 130, 333};

TEST(ShearRow, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (int width : widths) {
      Picture<uint8_t> in(width, 1), expected(width, 1), got(width, 1);
      fill(in, Content::noise, 3);
      for (int at_zero : {0, 5, -7, 16 * 20 + 3, -16 * 9, 16 * 4000, -16 * 4000}) {
        for (int per_column : {0, 3000, -3000, 70000}) {
          const RowDisparity disparity{static_cast<int64_t>(at_zero) << 16, per_column};
          plain::shear_row(in.view().row(0), width, disparity, expected.plane().row(0));
          k.shear_row(in.view().row(0), width, disparity, got.plane().row(0));
          ASSERT_EQ(expected, got) << width << " " << at_zero << " " << per_column;
          ASSERT_EQ(got.damage(), "");
        }
      }
    }
  });
}

TEST(ShearRow, moves_a_ramp_by_the_disparity) {
  std::vector<uint8_t> in(100), out(100);
  for (int x = 0; x < 100; ++x) in[static_cast<size_t>(x)] = static_cast<uint8_t>(2 * x);
  plain::shear_row(in.data(), 100, {int64_t{16 * 5 + 8} << 16, 0}, out.data());  // 5.5 px
  for (int x = 10; x < 99; ++x) EXPECT_EQ(out[static_cast<size_t>(x)], 2 * x - 11) << x;
}

TEST(MirrorRow, turns_rows_round_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    const Kernels k = kernels(level);
    for (int width : widths) {
      Picture<uint8_t> in(width, 1), got(width, 1);
      fill(in, Content::noise, 3);
      k.mirror_row(in.view().row(0), width, got.plane().row(0));
      for (int x = 0; x < width; ++x) ASSERT_EQ(got.at(x, 0), in.at(width - 1 - x, 0));
      ASSERT_EQ(got.damage(), "");
    }
  }
}

TEST(TextureRow, is_the_sum_written_out_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    const Kernels k = kernels(level);
    for (int width : {5, 21, 22, 64, 111}) {
      for (int window : {1, 5, 11, 21}) {
        Picture<uint8_t> in(width, 24);
        fill(in, Content::noise, static_cast<uint32_t>(window), uint8_t{62});
        std::vector<uint16_t> columns(static_cast<size_t>(width + texture_margin)), out(columns.size());
        const int r = window / 2;
        for (int y = r; y < 24 - r; ++y) {
          k.texture_row(in.view(), 31, window, y, y == r || y == 12, columns.data(), out.data());
          for (int x = r; x < width - r; ++x) {
            int sum = 0;
            for (int v = y - r; v <= y + r; ++v)
              for (int u = x - r; u <= x + r; ++u) sum += std::abs(in.at(u, v) - 31);
            ASSERT_EQ(out[static_cast<size_t>(x)], sum) << width << " " << window << " at " << x << "," << y;
          }
        }
      }
    }
  }
}

/// Candidates as they may come: costs that differ little, refusals, search ends.
struct Found {
  Found(int width, uint32_t seed) : rows(6, std::vector<uint16_t>(static_cast<size_t>(width + row_margin))) {
    std::minstd_rand random(seed);
    for (size_t x = 0; x < rows[0].size(); ++x) {
      const auto draw = [&](uint32_t n) { return static_cast<uint16_t>((random() >> 8) % n); };
      rows[0][x] = draw(16);
      rows[1][x] = static_cast<uint16_t>(100 + draw(60));
      rows[2][x] = static_cast<uint16_t>(rows[1][x] + draw(90));
      rows[3][x] = static_cast<uint16_t>(rows[1][x] + draw(90) * (draw(8) ? 1u : 0u));
      rows[4][x] = draw(3) ? uint16_t{0} : draw(4);
      rows[5][x] = static_cast<uint16_t>(rows[1][x] + draw(150));
    }
  }
  Hypothesis hypothesis(int first, int last, int least) {
    return {{rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data(), rows[4].data(), rows[5].data()}, first, last, least};
  }
  std::vector<std::vector<uint16_t>> rows;
};

TEST(ResolveRow, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (int width : {1, 40, 64, 65, 200}) {
      for (uint32_t seed = 1; seed < 20; ++seed) {
        Found one(width, seed), two(width, seed + 100);
        std::vector<uint16_t> texture(static_cast<size_t>(width + row_margin));
        for (size_t x = 0; x < texture.size(); ++x) texture[x] = static_cast<uint16_t>(x * 7 % 50);
        Resolve r{.width = width, .min_disparity = static_cast<int>(seed % 3) - 1, .disparities = 16, .texture_least = 10};
        r.unique = seed % 4 ? percent_factor(10) : 0;
        r.floor_margin = percent_factor(50);
        r.outside = -32005, r.low_texture = -32001, r.not_unique = -32002, r.left_right = -32003;
        const Hypothesis match = one.hypothesis(width / 6, width - width / 9, r.min_disparity);
        const Hypothesis floor = two.hypothesis(width / 5, width - width / 7, -8);
        // Far ones too, up to where 16 bits of 1/16 px end.
        const std::pair<const Hypothesis*, int> floors[] = {
            {nullptr, 8},    {&floor, 8},     {&floor, -8},    {&floor, 300},   {&floor, 1023},   {&floor, 1030},
            {&floor, 2046},  {&floor, 2047},  {&floor, 2049},  {&floor, 4095},  {&floor, 4100},   {&floor, -1030},
            {&floor, -2047}, {&floor, -2050}, {&floor, -4097}, {&floor, 70000}, {&floor, 1000000}};
        for (int per_column : {0, 2500}) {
          for (const auto& [second, px] : floors) {
            const RowDisparity disparity{int64_t{16 * px + 5} << 16, per_column};
            Picture<int16_t> expected(width, 1), got(width, 1);
            plain::resolve_row(r, match, second, disparity, texture.data(), expected.plane().row(0));
            k.resolve_row(r, match, second, disparity, texture.data(), got.plane().row(0));
            for (int x = 0; x < width; ++x)
              ASSERT_EQ(expected.at(x, 0), got.at(x, 0))
                  << "x " << x << " width " << width << " seed " << seed << (second ? " floor " : " ") << px;
            ASSERT_EQ(got.damage(), "");
          }
        }
      }
    }
  });
}

TEST(ResolveRow, the_cheaper_of_two_that_differ_wins_only_if_clearly_cheaper) {
  Found one(1, 1), two(1, 1);
  const auto set = [](Found& f, uint16_t index, uint16_t cost) {
    for (size_t i = 0; i < 6; ++i)
      f.rows[i][0] = std::array<uint16_t, 6>{index, cost, uint16_t(cost + 50), uint16_t(cost + 50), 0, cost}[i];
  };
  Resolve r{
      .width = 1, .disparities = 32, .unique = percent_factor(10), .floor_margin = percent_factor(50), .outside = -5, .not_unique = -2};
  const uint16_t texture = 0;
  int16_t out = 0;
  const auto resolve = [&] {
    const Hypothesis match = one.hypothesis(0, 1, 0), floor = two.hypothesis(0, 1, -8);
    plain::resolve_row(r, match, &floor, {int64_t{16 * 10} << 16, 0}, &texture, &out);
    return out;
  };
  set(one, 20, 100), set(two, 8, 200);
  EXPECT_EQ(resolve(), 16 * 20) << "a match that fits twice as well as the floor";
  set(two, 8, 140);
  EXPECT_EQ(resolve(), -2) << "the floor explains it nearly as well";
  set(two, 8, 80);
  EXPECT_EQ(resolve(), 16 * 10) << "the floor fits clearly better";
  set(two, 8, 95);
  EXPECT_EQ(resolve(), -2) << "the match fits nearly as well as the floor";
  set(one, 11, 95), set(two, 8, 95);
  EXPECT_EQ(resolve(), 16 * 10) << "both say the same within 1 px";
}

TEST(ResolveRow, a_floor_beyond_every_search_is_outside_or_loses) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (int px : {300, 2040, 2048, 4096, 1 << 20, -300, -2048, -4096, -(1 << 20)}) {
      Found one(1, 1), two(1, 1);
      for (size_t i = 0; i < 6; ++i) {
        one.rows[i][0] = std::array<uint16_t, 6>{3, 100, 150, 150, 0, 100}[i];
        two.rows[i][0] = std::array<uint16_t, 6>{8, 50, 150, 150, 0, 300}[i];
      }
      const Resolve r{.width = 1, .disparities = 256, .unique = percent_factor(10), .floor_margin = percent_factor(50), .outside = -5};
      std::vector<uint16_t> texture(1 + row_margin);
      int16_t out = 0;
      const Hypothesis match = one.hypothesis(0, 1, 0), floor = two.hypothesis(0, 1, -8);
      k.resolve_row(r, match, &floor, {int64_t{16} * px * 65536, 0}, texture.data(), &out);
      EXPECT_EQ(out, -5) << px;
      two.rows[1][0] = 300;
      k.resolve_row(r, match, &floor, {int64_t{16} * px * 65536, 0}, texture.data(), &out);
      EXPECT_EQ(out, 3 * 16) << px;
    }
  });
}

TEST(ResolveRow, the_sub_pixel_part_is_where_two_equal_slopes_meet) {
  // Costs of |d - 6.25| * 16 at 5, 6, 7: 20, 4, 12.
  Found one(1, 1);
  for (size_t i = 0; i < 5; ++i) one.rows[i][0] = std::array<uint16_t, 5>{6, 4, 20, 12, 0}[i];
  Resolve r{.width = 1, .disparities = 16};
  const uint16_t texture = 0;
  int16_t out = 0;
  const Hypothesis match = one.hypothesis(0, 1, 0);
  plain::resolve_row(r, match, nullptr, {}, &texture, &out);
  EXPECT_EQ(out, 16 * 6 + 4);
}

}  // namespace
}  // namespace vdisp::kernels
