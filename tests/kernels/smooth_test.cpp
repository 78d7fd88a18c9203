// smooth_test.cpp: the smoothing is the same at every level, and the mean and the median of nine pixels.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "tests/kernels/smooth_sizes.h"

namespace vdisp::kernels {
namespace {

TEST(Smoothing, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [smooth, plain_form] : {std::pair{k.mean3x3, &plain::mean3x3}, {k.median3x3, &plain::median3x3}}) {
      for (const auto& [width, height] : smooth_sizes()) {
        for (Content content : all_contents) {
          Picture<uint8_t> in(width, height), got(width, height), expected(width, height);
          fill(in, content, static_cast<uint32_t>(width * 7 + height));
          plain_form(in.view(), 0, height, expected.plane());
          smooth(in.view(), 0, height, got.plane());
          ASSERT_EQ(expected, got) << width << "x" << height << " content " << static_cast<int>(content);
          ASSERT_EQ(got.damage(), "");
        }
      }
    }
  });
}

TEST(Median3x3, is_the_fifth_of_nine_sorted) {
  for (const std::string& level : levels()) {
    Picture<uint8_t> in(131, 9), out(131, 9);
    fill(in, Content::noise, 4);
    kernels(level).median3x3(in.view(), 0, 9, out.plane());
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 131; ++x) {
        std::array<int, 9> nine;
        for (int i = 0; i < 9; ++i)
          nine[static_cast<size_t>(i)] = in.at(std::clamp(x + i % 3 - 1, 0, 130), std::clamp(y + i / 3 - 1, 0, 8));
        std::sort(nine.begin(), nine.end());
        ASSERT_EQ(out.at(x, y), nine[4]) << level << ' ' << x << ',' << y;
      }
    }
  }
}

TEST(Mean3x3, rounds_to_the_nearest) {
  for (const std::string& level : levels()) {
    // In each row of three, all sums of nine pixels from 0 to 9 times 255.
    Picture<uint8_t> in(2296, 3), out(2296, 3);
    for (int x = 0; x < 2296; ++x)
      for (int y = 0; y < 3; ++y) in.at(x, y) = static_cast<uint8_t>(std::clamp(x / 3 - 255 * y, 0, 255));
    kernels(level).mean3x3(in.view(), 1, 2, out.plane());
    for (int x = 1; x + 1 < 2296; ++x) {
      int sum = 0;
      for (int i = 0; i < 9; ++i) sum += in.at(x + i % 3 - 1, i / 3);
      ASSERT_EQ(out.at(x, 1), (2 * sum + 9) / 18) << level << " " << sum;
    }
  }
}

TEST(Smoothing, touches_only_the_rows_asked_for) {
  for (const std::string& level : levels()) {
    for (Smooth3x3* smooth : {kernels(level).mean3x3, kernels(level).median3x3}) {
      Picture<uint8_t> in(70, 9), out(70, 9), whole(70, 9), untouched(70, 9);
      fill(in, Content::noise, 5);
      smooth(in.view(), 0, 9, whole.plane());
      smooth(in.view(), 3, 6, out.plane());
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 70; ++x)
          ASSERT_EQ(out.at(x, y), (y < 3 || y >= 6 ? untouched : whole).at(x, y)) << level << " " << x << "," << y;
    }
  }
}

}  // namespace
}  // namespace vdisp::kernels
