// smooth_peer_test.cpp: the smoothing is what OpenCV makes of the same pixels, at every level.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/kernels/smooth_sizes.h"

namespace vdisp::kernels {
namespace {

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
  for (const auto& [width, height] : smooth_sizes()) {
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

TEST(SmoothPeer, mean_is_that_of_opencv_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    expect_as_opencv(kernels(level), false);
  }
}

TEST(SmoothPeer, median_is_that_of_opencv_at_every_level) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    expect_as_opencv(kernels(level), true);
  }
}

}  // namespace
}  // namespace vdisp::kernels
