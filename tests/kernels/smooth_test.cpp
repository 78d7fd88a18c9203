// smooth_test.cpp: the smoothing is what OpenCV makes of the same pixels, at every level.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

/// Widths around the strips the fast forms work in, and those of check.h.
std::vector<std::pair<int, int>> sizes() {
  std::vector<std::pair<int, int>> all = awkward_sizes;
  for (int width : {320, 639, 640, 641, 642, 703, 705, 1279, 1281, 1400}) all.emplace_back(width, 5);
  return all;
}

cv::Mat by_opencv(const Picture<uint8_t>& in, bool median) {
  const View8 v = in.view();
  cv::Mat copy(v.height, v.width, CV_8U), out;
  for (int y = 0; y < v.height; ++y) std::copy_n(v.row(y), v.width, copy.ptr(y));
  if (median)
    cv::medianBlur(copy, out, 3);
  else
    cv::blur(copy, out, {3, 3}, {-1, -1}, cv::BORDER_REPLICATE);
  return out;
}

void expect_as_opencv(const Kernels& k, bool median) {
  Smooth3x3* smooth = median ? k.median3x3 : k.mean3x3;
  for (const auto& [width, height] : sizes()) {
    for (Content content : all_contents) {
      Picture<uint8_t> in(width, height), got(width, height), expected(width, height);
      fill(in, content, static_cast<uint32_t>(width * 7 + height));
      const cv::Mat peer = by_opencv(in, median);
      for (int y = 0; y < height; ++y) std::copy_n(peer.ptr(y), width, expected.plane().row(y));
      smooth(in.view(), 0, height, got.plane());
      ASSERT_EQ(expected, got) << width << "x" << height << " content " << static_cast<int>(content);
      ASSERT_EQ(got.damage(), "");
    }
  }
}

TEST(Mean3x3, is_that_of_opencv_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    expect_as_opencv(kernels(level), false);
  }
}

TEST(Median3x3, is_that_of_opencv_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    expect_as_opencv(kernels(level), true);
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
