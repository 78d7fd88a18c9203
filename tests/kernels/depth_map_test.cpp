// depth_map_test.cpp: counts by column are the same at every level, and what the contract says.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/depth_map.h"

#include "daemon/kernels/shrink.h"
#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

void fill_depths(Picture<int16_t>& disparity, uint32_t seed, int most) {
  std::minstd_rand random(seed + 1);
  const Plane<int16_t> p = disparity.plane();
  for (int y = 0; y < p.height; ++y) {
    for (int x = 0; x < p.width; ++x) {
      const int kind = static_cast<int>(random() >> 8) % 8;
      const int value = static_cast<int>(random() >> 8) % (16 * most + 40) - 20;
      p.row(y)[x] = static_cast<int16_t>(kind == 0 ? -32001 : kind == 1 ? INT16_MIN : kind == 2 ? INT16_MAX : kind == 3 ? 17 : value);
    }
  }
}

TEST(CountDepth, is_the_same_at_every_level) {
  for (const auto& [width, height] : {std::pair{1, 1}, {17, 5}, {63, 9}, {64, 3}, {65, 300}, {131, 9}, {320, 240}, {333, 600}}) {
    for (const int disparities : {16, 32, 48, 64, 80, 256}) {
      Picture<int16_t> disparity(width, height), expected(width, disparities), got(width, disparities);
      fill_depths(disparity, static_cast<uint32_t>(width), disparities);
      std::vector<uint8_t> scratch(depth_scratch(width, height));
      plain::count_depth(disparity.view(), expected.plane(), scratch.data());
      at_each_level([&](const std::string&, const Kernels& k) {
        k.count_depth(disparity.view(), got.plane(), scratch.data());
        ASSERT_EQ(expected, got) << width << "x" << height << " " << disparities;
        ASSERT_EQ(got.damage(), "");
      });
    }
  }
}

TEST(CountDepth, each_pixel_counts_in_its_column_at_its_whole_disparity) {
  Picture<int16_t> disparity(100, 40), counts(100, 32);
  fill(disparity, Content::black, 0);
  for (int y = 3; y < 20; ++y) disparity.at(70, y) = static_cast<int16_t>(16 * 5 + y % 16);
  disparity.at(70, 30) = 16 * 6;
  disparity.at(71, 0) = 15;
  disparity.at(71, 1) = 16 * 32;
  disparity.at(71, 2) = 16 * 32 - 1;
  disparity.at(71, 3) = -32001;
  std::vector<uint8_t> scratch(depth_scratch(100, 40));
  for (const std::string& level : levels()) {
    kernels(level).count_depth(disparity.view(), counts.plane(), scratch.data());
    for (int d = 0; d < 32; ++d) {
      for (int x = 0; x < 100; ++x) {
        const int expected = x == 70 ? (d == 5 ? 17 : d == 6 ? 1 : 0) : x == 71 && d == 31 ? 1 : 0;
        ASSERT_EQ(counts.at(x, d), expected) << level << " " << x << "," << d;
      }
    }
  }
}

TEST(CountDepth, a_count_stays_at_its_most) {
  Picture<int16_t> disparity(64, 33000), counts(64, 16);
  for (int y = 0; y < 33000; ++y)
    for (int x = 0; x < 64; ++x) disparity.at(x, y) = 16 * 3;
  std::vector<uint8_t> scratch(depth_scratch(64, 33000));
  for (const std::string& level : levels()) {
    kernels(level).count_depth(disparity.view(), counts.plane(), scratch.data());
    EXPECT_EQ(counts.at(9, 3), 32767) << level;
  }
}

TEST(Shrink, is_the_same_at_every_level) {
  for (const auto& [width, height] : awkward_sizes) {
    for (const int factor : {1, 2, 3, 4, 16}) {
      for (Content content : all_contents) {
        Picture<uint8_t> in(width * factor + factor - 1, height * factor), expected(width, height), got(width, height);
        fill(in, content, static_cast<uint32_t>(width));
        plain::shrink(in.view(), factor, 0, height, expected.plane());
        at_each_level([&](const std::string&, const Kernels& k) {
          k.shrink(in.view(), factor, 0, height, got.plane());
          ASSERT_EQ(expected, got) << width << "x" << height << " / " << factor;
          ASSERT_EQ(got.damage(), "");
        });
      }
    }
  }
}

TEST(Shrink, is_the_mean_rounded_half_up) {
  Picture<uint8_t> in(128, 4), out(64, 2);
  fill(in, Content::black, 0);
  in.at(2, 0) = 1, in.at(3, 1) = 1;                      // 2 / 4: half up
  in.at(4, 2) = 1;                                       // 1 / 4
  for (int x : {6, 7}) in.at(x, 2) = in.at(x, 3) = 255;  // all four
  for (const std::string& level : levels()) {
    kernels(level).shrink(in.view(), 2, 0, 2, out.plane());
    EXPECT_EQ(out.at(1, 0), 1) << level;
    EXPECT_EQ(out.at(2, 1), 0) << level;
    EXPECT_EQ(out.at(3, 1), 255) << level;
    EXPECT_EQ(out.at(63, 1), 0) << level;
  }
}

}  // namespace
}  // namespace vdisp::kernels
