// hamming_test.cpp: the census search is the same at every level, finds what was shifted, and refuses what looks alike everywhere.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/hamming.h"

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

constexpr int16_t refused = -32001, outside = -32005;

HammingSearch search_in(Picture<uint8_t>& left, Picture<uint8_t>& right, int window, int disparities, int confidence) {
  return {.left = left.view(),
          .right = right.view(),
          .window = window,
          .disparities = disparities,
          .confidence = confidence,
          .refused = refused,
          .outside = outside};
}

/// The right view of a scene that lies `shift` px displaced, with other noise in a part of the bits.
void look_from_right(Picture<uint8_t>& left, Picture<uint8_t>& right, int shift, int noisy_bits) {
  std::minstd_rand random(7);
  const Plane<uint8_t> l = left.plane(), r = right.plane();
  for (int y = 0; y < l.height; ++y) {
    for (int x = 0; x < l.width; ++x) {
      const auto noise = static_cast<uint8_t>((random() >> 8) & ((1u << noisy_bits) - 1));
      r.row(y)[x] = static_cast<uint8_t>((x + shift < l.width ? l.row(y)[x + shift] : 0) ^ noise);
    }
  }
}

TEST(MatchHamming, is_the_same_at_every_level) {
  for (const auto& [width, height] : {std::pair{60, 24}, {131, 25}, {200, 23}}) {
    for (const int window : {3, 5, 7, 9, 11, 13, 15, 17, 21}) {
      for (const int disparities : {16, 48}) {
        for (Content content : {Content::noise, Content::white, Content::stripes, Content::few_levels}) {
          Picture<uint8_t> left(width, height), right(width, height);
          fill(left, content, 3);
          fill(right, content, content == Content::noise ? 4 : 3);
          if (content == Content::noise) look_from_right(left, right, 9, 3);
          const int confidence = disparities * window * window;
          HammingScratch scratch(width, disparities);
          Picture<int16_t> expected(width, height), got(width, height);
          const HammingSearch search = search_in(left, right, window, disparities, confidence);
          plain::match_hamming(search, 0, height, scratch, expected.plane());
          at_each_level([&](const std::string&, const Kernels& k) {
            k.match_hamming(search, 0, height, scratch, got.plane());
            ASSERT_EQ(expected, got) << width << "x" << height << " window " << window << " disparities " << disparities;
            ASSERT_EQ(got.damage(), "");
          });
        }
      }
    }
  }
}

TEST(MatchHamming, the_widest_search_does_not_overflow) {
  Picture<uint8_t> left(330, 25), right(330, 25);
  fill(left, Content::white, 1);
  fill(right, Content::black, 1);
  const HammingSearch search = search_in(left, right, 21, 256, 1);
  HammingScratch scratch(330, 256);
  for (const std::string& level : levels()) {
    Picture<int16_t> out(330, 25);
    kernels(level).match_hamming(search, 0, 25, scratch, out.plane());
    EXPECT_EQ(out.at(300, 12), refused) << level << ": all cost the same, so there is no confidence";
  }
  // All 8 bits of each pixel differ but at one shift, and partly at those next to it: the sum over the shifts is as great as it can be
  // where anything is found, and the confidence asks for all of it.
  for (int y = 0; y < 25; ++y)
    for (int x = 190; x <= 210; ++x) right.at(x, y) = 255;
  const int costs = 8 * 21 * (256 * 21 - 21 * 21);
  for (const std::string& level : levels()) {
    Picture<int16_t> out(330, 25);
    kernels(level).match_hamming(search_in(left, right, 21, 256, costs), 0, 25, scratch, out.plane());
    EXPECT_EQ(out.at(300, 12), 16 * 100) << level;
    kernels(level).match_hamming(search_in(left, right, 21, 256, costs + 1), 0, 25, scratch, out.plane());
    EXPECT_EQ(out.at(300, 12), refused) << level;
  }
}

TEST(MatchHamming, finds_the_shift_where_window_and_search_are_inside) {
  Picture<uint8_t> left(100, 20), right(100, 20);
  fill(left, Content::noise, 1);
  look_from_right(left, right, 13, 0);
  const HammingSearch search = search_in(left, right, 9, 16, 16 * 81 * 2);
  HammingScratch scratch(100, 16);
  for (const std::string& level : levels()) {
    Picture<int16_t> out(100, 20);
    kernels(level).match_hamming(search, 0, 20, scratch, out.plane());
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 100; ++x) {
        const bool inside = y >= 4 && y < 16 && x >= 4 + 15 && x < 96;
        ASSERT_EQ(out.at(x, y), inside ? 16 * 13 : outside) << level << " " << x << "," << y;
      }
    }
  }
}

TEST(MatchHamming, of_equals_the_smallest_shift) {
  Picture<uint8_t> left(100, 20), right(100, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 100; ++x) left.at(x, y) = right.at(x, y) = static_cast<uint8_t>(x % 5 == 0 ? 255 : 0);
  const HammingSearch search = search_in(left, right, 5, 32, 0);
  HammingScratch scratch(100, 32);
  for (const std::string& level : levels()) {
    Picture<int16_t> out(100, 20);
    kernels(level).match_hamming(search, 0, 20, scratch, out.plane());
    EXPECT_EQ(out.at(60, 10), 0) << level << ": 0, 5, 10 ... fit as well";
  }
}

/// By hand: a bit of each pixel differs, 9 in a window of 3, but where the window meets the three columns that are as the left view.
TEST(MatchHamming, confidence_is_the_average_over_the_shifts_less_the_best) {
  Picture<uint8_t> left(60, 9), right(60, 9);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 60; ++x) {
      left.at(x, y) = 0;
      right.at(x, y) = 1;
    }
  }
  // The window of 3 around column 30 meets the columns 20 to 22 of the right view at a shift of 9, and parts of them at 7, 8, 10, 11.
  for (int y = 0; y < 9; ++y)
    for (int x : {20, 21, 22}) right.at(x, y) = 0;
  const int costs = 16 * 9 - (3 + 6 + 9 + 6 + 3);
  HammingScratch scratch(60, 16);
  for (const std::string& level : levels()) {
    Picture<int16_t> out(60, 9);
    kernels(level).match_hamming(search_in(left, right, 3, 16, costs), 0, 9, scratch, out.plane());
    EXPECT_EQ(out.at(30, 4), 16 * 9) << level;
    kernels(level).match_hamming(search_in(left, right, 3, 16, costs + 1), 0, 9, scratch, out.plane());
    EXPECT_EQ(out.at(30, 4), refused) << level;
  }
}

TEST(MatchHamming, bands_of_rows_give_the_whole_and_touch_nothing_else) {
  Picture<uint8_t> left(120, 40), right(120, 40);
  fill(left, Content::noise, 5);
  look_from_right(left, right, 6, 4);
  const HammingSearch search = search_in(left, right, 7, 16, 16 * 49);
  HammingScratch scratch(120, 16);
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    Picture<int16_t> whole(120, 40), parts(120, 40), untouched(120, 40);
    k.match_hamming(search, 0, 40, scratch, whole.plane());
    for (const auto& [first, last] : {std::pair{0, 2}, {2, 11}, {11, 12}, {12, 39}})
      k.match_hamming(search, first, last, scratch, parts.plane());
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 120; ++x) ASSERT_EQ(parts.at(x, y), (y < 39 ? whole : untouched).at(x, y)) << level << " " << x << "," << y;
    ASSERT_EQ(parts.damage(), "");
  }
}

}  // namespace
}  // namespace vdisp::kernels
