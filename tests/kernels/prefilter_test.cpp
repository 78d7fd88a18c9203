// prefilter_test.cpp: the pre-filters are the same bytes at every level, and what their contract says.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

TEST(XSobel, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : awkward_sizes) {
      for (Content content : all_contents) {
        Picture<uint8_t> in(width, height), expected(width, height), got(width, height);
        fill(in, content, static_cast<uint32_t>(width * 31 + height));
        for (int cap : {1, 31, 63, 127}) {
          plain::x_sobel(in.view(), cap, 0, height, expected.plane());
          k.x_sobel(in.view(), cap, 0, height, got.plane());
          ASSERT_EQ(expected, got) << width << "x" << height << " cap " << cap;
          ASSERT_EQ(got.damage(), "");
        }
      }
    }
  });
}

TEST(XSobel, a_step_of_one_level_gives_four_at_the_step) {
  Picture<uint8_t> in(8, 3), out(8, 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 8; ++x) in.at(x, y) = x < 4 ? 100 : 101;
  plain::x_sobel(in.view(), 31, 0, 3, out.plane());
  const std::vector<int> expected{31, 31, 31, 35, 35, 31, 31, 31};
  for (int x = 0; x < 8; ++x) EXPECT_EQ(out.at(x, 1), expected[static_cast<size_t>(x)]) << x;
}

TEST(XSobel, touches_only_the_rows_asked_for) {
  at_each_level([](const std::string&, const Kernels& k) {
    Picture<uint8_t> in(70, 9), out(70, 9), untouched(70, 9);
    fill(in, Content::noise, 5);
    k.x_sobel(in.view(), 31, 3, 6, out.plane());
    for (int y : {0, 1, 2, 6, 7, 8})
      for (int x = 0; x < 70; ++x) ASSERT_EQ(out.at(x, y), untouched.at(x, y)) << x << "," << y;
  });
}

/// Sizes of check.h and those around the strips of the fast form.
std::vector<std::pair<int, int>> log_sizes() {
  std::vector<std::pair<int, int>> all = awkward_sizes;
  for (int width : {9, 11, 40, 639, 640, 641, 645, 650, 704, 1281}) all.emplace_back(width, 13);
  return all;
}

TEST(LogFilter, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : log_sizes()) {
      for (Content content : all_contents) {
        Picture<uint8_t> in(width, height), expected(width, height), got(width, height);
        fill(in, content, static_cast<uint32_t>(width * 31 + height));
        for (const auto& [window, cap] : {std::pair{9, 1}, {9, 31}, {9, 127}, {11, 31}, {11, 127}}) {
          plain::log_filter(in.view(), window, cap, 0, height, expected.plane());
          k.log_filter(in.view(), window, cap, 0, height, got.plane());
          ASSERT_EQ(expected, got) << width << "x" << height << " window " << window << " cap " << cap;
          ASSERT_EQ(got.damage(), "");
        }
      }
    }
  });
}

using Weights = std::vector<int>;

Weights convolved(const Weights& a, const Weights& b) {
  Weights both(a.size() + b.size() - 1, 0);
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t k = 0; k < b.size(); ++k) both[i + k] += a[i] * b[k];
  return both;
}

TEST(LogFilter, is_the_laplacian_of_three_boxes) {
  for (int window : {9, 11}) {
    const Weights g = convolved(convolved({1, 1, 1}, {1, 1, 1}), Weights(static_cast<size_t>(window) - 6, 1));
    const Weights smooth = convolved(g, {0, 1, 0}), second = convolved(g, {1, -2, 1});
    Picture<uint8_t> in(60, 40), out(60, 40);
    fill(in, Content::noise, 3, uint8_t{120});
    plain::log_filter(in.view(), window, 127, 0, 40, out.plane());
    double squares = 0;
    const int reach = window / 2;
    for (int y = reach; y < 40 - reach; ++y) {
      for (int x = reach; x < 60 - reach; ++x) {
        int response = 0;
        for (size_t j = 0; j < smooth.size(); ++j)
          for (size_t i = 0; i < smooth.size(); ++i)
            response +=
                (second[i] * smooth[j] + smooth[i] * second[j]) * in.at(x + static_cast<int>(i) - reach, y + static_cast<int>(j) - reach);
        const double expected = std::clamp(response / (window == 9 ? 64. : 128.), -127., 127.) + 127;
        ASSERT_NEAR(out.at(x, y), expected, 4) << window << " " << x << "," << y;
        squares += (out.at(x, y) - expected) * (out.at(x, y) - expected);
      }
    }
    // Rounding the end alone would give 1/12.
    EXPECT_LT(squares / ((40 - 2 * reach) * (60 - 2 * reach)), 0.25) << window;
  }
}

TEST(LogFilter, is_the_same_at_every_level_where_16_bits_are_not_enough) {
  // The picture that makes the sum before the last box as large as it can be, for window 11 more than 16 bits hold.
  const Weights bell = convolved({1, 1, 1}, {1, 1, 1}), dent{1, 0, 0, -2, 0, 0, 1};
  const Weights g = convolved(bell, {0, 1, 1, 1, 1, 1, 0}), h = convolved(dent, {1, 1, 1, 1, 1}), across = convolved(bell, {0, 1, 0});
  for (int sign : {1, -1}) {
    Picture<uint8_t> in(140, 60), expected(140, 60), got(140, 60);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 140; ++x) {
        const size_t i = static_cast<size_t>(x % 7), j = static_cast<size_t>(y % 11);
        in.at(x, y) = sign * (across[i] * h[j] + dent[i] * g[j]) > 0 ? 255 : 0;
      }
    }
    plain::log_filter(in.view(), 11, 127, 0, 60, expected.plane());
    at_each_level([&](const std::string&, const Kernels& k) {
      k.log_filter(in.view(), 11, 127, 0, 60, got.plane());
      EXPECT_EQ(expected, got);
    });
  }
}

TEST(LogFilter, flat_areas_and_ramps_are_nothing) {
  for (int window : {9, 11}) {
    for (const auto& [dx, dy, level] :
         std::vector<std::array<int, 3>>{{0, 0, 0}, {0, 0, 255}, {3, 0, 10}, {0, -4, 200}, {2, 3, 7}, {-1, 5, 60}}) {
      Picture<uint8_t> in(50, 30), out(50, 30);
      for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 50; ++x) in.at(x, y) = static_cast<uint8_t>(level + dx * x + dy * y);
      plain::log_filter(in.view(), window, 31, 0, 30, out.plane());
      for (int y = window / 2; y < 30 - window / 2; ++y)
        for (int x = window / 2; x < 50 - window / 2; ++x) ASSERT_EQ(out.at(x, y), 31) << window << " slope " << dx << "," << dy;
    }
  }
}

TEST(LogFilter, a_bright_spot_is_below_and_a_dark_one_above_the_middle) {
  for (int window : {9, 11}) {
    for (int spot : {140, 60}) {
      Picture<uint8_t> in(31, 31), out(31, 31);
      fill(in, Content::white, 0, uint8_t{100});
      for (int y = 14; y < 17; ++y)
        for (int x = 14; x < 17; ++x) in.at(x, y) = static_cast<uint8_t>(spot);
      plain::log_filter(in.view(), window, 127, 0, 31, out.plane());
      const int sign = spot > 100 ? -1 : 1;
      EXPECT_GT(sign * (out.at(15, 15) - 127), 20) << window;
      EXPECT_LT(sign * (out.at(20, 15) - 127), 0) << "the ring around it has the other sign, window " << window;
      EXPECT_EQ(out.at(15, 15 + window / 2 + 2), 127) << "and beyond the window there is nothing";
    }
  }
}

TEST(LogFilter, brightness_changes_nothing) {
  for (int window : {9, 11}) {
    Picture<uint8_t> in(90, 20), brighter(90, 20), out(90, 20), same(90, 20);
    fill(in, Content::noise, 11, uint8_t{150});
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 90; ++x) brighter.at(x, y) = static_cast<uint8_t>(in.at(x, y) + 87);
    plain::log_filter(in.view(), window, 63, 0, 20, out.plane());
    plain::log_filter(brighter.view(), window, 63, 0, 20, same.plane());
    EXPECT_EQ(out, same);
  }
}

TEST(LogFilter, touches_only_the_rows_asked_for) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    Picture<uint8_t> in(70, 15), out(70, 15), whole(70, 15), untouched(70, 15);
    fill(in, Content::noise, 5);
    k.log_filter(in.view(), 9, 31, 0, 15, whole.plane());
    k.log_filter(in.view(), 9, 31, 4, 7, out.plane());
    for (int y = 0; y < 15; ++y)
      for (int x = 0; x < 70; ++x) ASSERT_EQ(out.at(x, y), (y < 4 || y >= 7 ? untouched : whole).at(x, y)) << level << " " << x << "," << y;
  }
}

TEST(Kernels, an_unknown_level_is_refused_with_those_there_are) {
  try {
    kernels("mmx");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("plain"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vdisp::kernels
