// census_test.cpp: census codes are the same bytes at every level, and what their contract says.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

/// Sizes of check.h and those around the vectors with two columns of border on each side.
std::vector<std::pair<int, int>> sizes() {
  std::vector<std::pair<int, int>> all = awkward_sizes;
  for (int width : {2, 4, 5, 18, 19, 20, 21, 34, 36, 66, 67, 68, 69, 130, 320}) all.emplace_back(width, 6);
  return all;
}

TEST(Census3x3, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : sizes()) {
      for (Content content : all_contents) {
        Picture<uint8_t> in(width, height), expected(width, height), got(width, height);
        fill(in, content, static_cast<uint32_t>(width * 31 + height));
        plain::census3x3(in.view(), 0, height, expected.plane());
        k.census3x3(in.view(), 0, height, got.plane());
        ASSERT_EQ(expected, got) << width << "x" << height;
        ASSERT_EQ(got.damage(), "");
      }
    }
  });
}

TEST(Census5x5, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : sizes()) {
      for (Content content : all_contents) {
        Picture<uint8_t> in(width, height), expected(width, height), got(width, height), more(width, height), got_more(width, height);
        fill(in, content, static_cast<uint32_t>(width * 31 + height));
        plain::census5x5(in.view(), 0, height, expected.plane(), more.plane());
        k.census5x5(in.view(), 0, height, got.plane(), got_more.plane());
        ASSERT_EQ(expected, got) << width << "x" << height;
        ASSERT_EQ(more, got_more) << width << "x" << height;
        ASSERT_EQ(got.damage() + got_more.damage(), "");
      }
    }
  });
}

/// A picture of 7x5 whose middle pixel is 100 and whose other pixels are as bright.
Picture<uint8_t> even() {
  Picture<uint8_t> in(7, 5);
  fill(in, Content::white, 0, uint8_t{100});
  return in;
}

TEST(Census3x3, each_darker_neighbour_sets_its_bit_row_by_row_from_the_highest) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    int bit = 7;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        Picture<uint8_t> in = even(), out(7, 5);
        k.census3x3(in.view(), 0, 5, out.plane());
        EXPECT_EQ(out.at(3, 2), 0) << "what is equal sets none";
        in.at(3 + dx, 2 + dy) = 99;
        k.census3x3(in.view(), 0, 5, out.plane());
        EXPECT_EQ(out.at(3, 2), 1 << bit) << level << dx << "," << dy;
        in.at(3 + dx, 2 + dy) = 101;
        k.census3x3(in.view(), 0, 5, out.plane());
        EXPECT_EQ(out.at(3, 2), 0) << level << dx << "," << dy;
        --bit;
      }
    }
    EXPECT_EQ(bit, -1);
  }
}

TEST(Census5x5, each_pixel_brighter_than_its_mirror_image_sets_its_bit) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    for (int i = 0; i < 25; ++i) {
      const int dx = i % 5 - 2, dy = i / 5 - 2;
      Picture<uint8_t> in = even(), out(7, 5), more(7, 5);
      in.at(3 + dx, 2 + dy) = i < 12 ? 101 : 99;  // behind the centre: darker does what brighter does before it
      k.census5x5(in.view(), 0, 5, out.plane(), more.plane());
      const int expected = i == 12 ? 0 : 1 << (i < 12 ? 11 - i : i - 13);
      EXPECT_EQ(out.at(3, 2) * 16 + more.at(3, 2), expected) << level << dx << "," << dy;
    }
  }
}

TEST(Census, brightness_and_contrast_change_nothing) {
  Picture<uint8_t> in(90, 20), other(90, 20), out(90, 20), same(90, 20), more(90, 20), same_more(90, 20);
  fill(in, Content::noise, 11, uint8_t{80});
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 90; ++x) other.at(x, y) = static_cast<uint8_t>(2 * in.at(x, y) + 87);
  plain::census3x3(in.view(), 0, 20, out.plane());
  plain::census3x3(other.view(), 0, 20, same.plane());
  EXPECT_EQ(out, same);
  plain::census5x5(in.view(), 0, 20, out.plane(), more.plane());
  plain::census5x5(other.view(), 0, 20, same.plane(), same_more.plane());
  EXPECT_EQ(out, same);
  EXPECT_EQ(more, same_more);
}

TEST(Census, beyond_the_border_the_border_is_repeated) {
  Picture<uint8_t> in(40, 12), wide(44, 16);
  fill(in, Content::noise, 9);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 44; ++x) wide.at(x, y) = in.at(std::clamp(x - 2, 0, 39), std::clamp(y - 2, 0, 11));
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    Picture<uint8_t> out(40, 12), more(40, 12), wide_out(44, 16), wide_more(44, 16);
    k.census3x3(in.view(), 0, 12, out.plane());
    k.census3x3(wide.view(), 0, 16, wide_out.plane());
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 40; ++x) ASSERT_EQ(out.at(x, y), wide_out.at(x + 2, y + 2)) << level << " " << x << "," << y;
    k.census5x5(in.view(), 0, 12, out.plane(), more.plane());
    k.census5x5(wide.view(), 0, 16, wide_out.plane(), wide_more.plane());
    for (int y = 0; y < 12; ++y) {
      for (int x = 0; x < 40; ++x) {
        ASSERT_EQ(out.at(x, y), wide_out.at(x + 2, y + 2)) << level << " " << x << "," << y;
        ASSERT_EQ(more.at(x, y), wide_more.at(x + 2, y + 2)) << level << " " << x << "," << y;
      }
    }
  }
}

TEST(Census, touches_only_the_rows_asked_for) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    Picture<uint8_t> in(70, 9), three(70, 9), five(70, 9), more(70, 9), untouched(70, 9);
    Picture<uint8_t> whole3(70, 9), whole5(70, 9), whole_more(70, 9);
    fill(in, Content::noise, 5);
    k.census3x3(in.view(), 0, 9, whole3.plane());
    k.census5x5(in.view(), 0, 9, whole5.plane(), whole_more.plane());
    k.census3x3(in.view(), 3, 6, three.plane());
    k.census5x5(in.view(), 3, 6, five.plane(), more.plane());
    for (int y = 0; y < 9; ++y) {
      const bool asked = y >= 3 && y < 6;
      for (int x = 0; x < 70; ++x) {
        ASSERT_EQ(three.at(x, y), (asked ? whole3 : untouched).at(x, y)) << level << " " << x << "," << y;
        ASSERT_EQ(five.at(x, y), (asked ? whole5 : untouched).at(x, y)) << level << " " << x << "," << y;
        ASSERT_EQ(more.at(x, y), (asked ? whole_more : untouched).at(x, y)) << level << " " << x << "," << y;
      }
    }
  }
}

}  // namespace
}  // namespace vdisp::kernels
