// debayer_peer_test.cpp: de-Bayer is OpenCV's to one level, inside the image.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/imgproc.hpp>

#include "tests/kernels/bayer_patterns.h"
#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

TEST(DebayerPeer, is_opencvs_to_one_level_inside) {
  // OpenCV names the four by the second row from the second column on.
  const std::array codes{cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGR2GRAY};
  for (Bayer pattern : all_patterns) {
    for (const auto& [width, height] : {std::pair{640, 480}, {131, 41}}) {
      Picture<uint8_t> in(width, height, 0), out(width, height);
      fill(in, Content::noise, 11);
      plain::debayer(in.view(), pattern, 0, height, out.plane());
      cv::Mat expected;
      cv::cvtColor(cv::Mat(height, width, CV_8U, in.plane().data), expected, codes[static_cast<size_t>(pattern)]);
      for (int y = 1; y + 1 < height; ++y)
        for (int x = 1; x + 1 < width; ++x)
          ASSERT_NEAR(out.at(x, y), expected.at<uint8_t>(y, x), 1) << name(pattern) << ' ' << x << ',' << y;
    }
  }
}

}  // namespace
}  // namespace vdisp::kernels
