// debayer_test.cpp: de-Bayer gives the luma of colours exactly where they are flat, and the same at every level.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/bayer_patterns.h"
#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

/// The colour at a pixel: 0 red, 1 green, 2 blue.
int colour_at(Bayer pattern, int x, int y) {
  const char letter = name(pattern)[y % 2 * 2 + x % 2];
  return letter == 'r' ? 0 : letter == 'g' ? 1 : 2;
}

TEST(Debayer, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    std::vector<std::pair<int, int>> sizes = awkward_sizes;
    for (int width = 30; width < 40; ++width) sizes.emplace_back(width, 4);
    for (int width = 62; width < 72; ++width) sizes.emplace_back(width, 3);
    for (const auto& [width, height] : sizes) {
      for (Content content : all_contents) {
        for (Bayer pattern : all_patterns) {
          Picture<uint8_t> in(width, height), expected(width, height), got(width, height);
          fill(in, content, static_cast<uint32_t>(width * 31 + height));
          plain::debayer(in.view(), pattern, 0, height, expected.plane());
          k.debayer(in.view(), pattern, 0, height, got.plane());
          ASSERT_EQ(expected, got) << width << "x" << height << ' ' << name(pattern);
          ASSERT_EQ(got.damage(), "");
        }
      }
    }
  });
}

TEST(Debayer, reads_nothing_beyond_the_image) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (int width : {1, 2, 3, 33, 64, 67, 130}) {
      const std::vector<uint8_t> pixels(static_cast<size_t>(width) * 3, 9);  // asan guards both ends
      Picture<uint8_t> out(width, 3);
      k.debayer({pixels.data(), width, 3, width}, Bayer::rggb, 0, 3, out.plane());
      ASSERT_EQ(out.damage(), "");
    }
  });
}

TEST(Debayer, a_flat_colour_gives_its_luma_at_every_pixel) {
  for (Bayer pattern : all_patterns) {
    for (const auto& [red, green, blue] : {std::array{255, 255, 255},
                                           {0, 0, 0},
                                           {255, 0, 0},
                                           {0, 255, 0},
                                           {0, 0, 255},
                                           {200, 30, 97},
                                           {1, 2, 3},
                                           {254, 253, 7},
                                           {13, 128, 250}}) {
      Picture<uint8_t> in(37, 11), out(37, 11);
      for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 37; ++x)
          in.at(x, y) = static_cast<uint8_t>(std::array{red, green, blue}[static_cast<size_t>(colour_at(pattern, x, y))]);
      plain::debayer(in.view(), pattern, 0, 11, out.plane());
      const double luma = 0.299 * red + 0.587 * green + 0.114 * blue;
      EXPECT_NEAR(out.at(0, 0), luma, 0.52);
      for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 37; ++x) ASSERT_EQ(out.at(x, y), out.at(0, 0)) << name(pattern) << ' ' << x << ',' << y;
    }
  }
}

TEST(Debayer, a_ramp_of_every_colour_is_a_ramp_of_luma) {
  // Bilinear interpolation is exact on planes.
  for (Bayer pattern : all_patterns) {
    Picture<uint8_t> in(40, 40), out(40, 40);
    const auto value = [](int colour, int x, int y) { return colour == 0 ? 2 * x + 3 * y : colour == 1 ? 5 * x + 10 : 200 - 4 * y; };
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) in.at(x, y) = static_cast<uint8_t>(value(colour_at(pattern, x, y), x, y));
    plain::debayer(in.view(), pattern, 0, 40, out.plane());
    for (int y = 1; y < 39; ++y)
      for (int x = 1; x < 39; ++x)
        ASSERT_NEAR(out.at(x, y), 0.299 * value(0, x, y) + 0.587 * value(1, x, y) + 0.114 * value(2, x, y), 0.52) << name(pattern);
  }
}

TEST(Debayer, bands_of_rows_give_what_all_rows_give_and_touch_no_others) {
  at_each_level([](const std::string&, const Kernels& k) {
    Picture<uint8_t> in(90, 21), whole(90, 21), few(90, 21), untouched(90, 21);
    fill(in, Content::noise, 5);
    k.debayer(in.view(), Bayer::grbg, 0, 21, whole.plane());
    k.debayer(in.view(), Bayer::grbg, 7, 12, few.plane());
    for (int y = 0; y < 21; ++y)
      for (int x = 0; x < 90; ++x) ASSERT_EQ(few.at(x, y), (y >= 7 && y < 12 ? whole : untouched).at(x, y)) << x << ',' << y;
  });
}

}  // namespace
}  // namespace vdisp::kernels
