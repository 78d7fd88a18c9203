// prefilter_test.cpp: the pre-filters are the same bytes at every level, and what their contract says.
// SPDX-License-Identifier: Apache-2.0
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
