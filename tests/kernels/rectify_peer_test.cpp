// rectify_peer_test.cpp: rectification is cv::remap to one level.
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string_view>

#include "tests/kernels/rectify_maps.h"

namespace vdisp::kernels {
namespace {

/// The plain form, which rectify_test.cpp compares with the others, is within a level of cv::remap.
void expect_near_remap(const Raw& raw, const Map& map, int width, int height) {
  Maps maps(width, height, map.source);
  const View8 view = raw.view();
  Picture<uint8_t> got(width, height);
  plain::rectify(maps.table(view), view, 0, height, got.plane());
  const cv::Mat pixels(view.height, view.width, CV_8U, const_cast<uint8_t*>(view.data), static_cast<size_t>(view.stride));
  const cv::Mat whole(height, width, CV_16SC2, maps.whole.plane().data, static_cast<size_t>(maps.whole.plane().stride) * 2);
  const cv::Mat part(height, width, CV_16U, maps.part.plane().data, static_cast<size_t>(maps.part.plane().stride) * 2);
  cv::Mat expected;
  cv::remap(pixels, expected, whole, part, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  int greatest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) greatest = std::max(greatest, std::abs(expected.at<uint8_t>(y, x) - got.at(x, y)));
  EXPECT_LE(greatest, 1);
}

TEST(RectifyPeer, all_maps_sizes_and_strides_are_near_remap) {
  for (const auto& [raw_width, raw_height] : raw_sizes) {
    for (int extra : {0, 8, 13}) {
      const Raw raw(raw_width, raw_height, extra);
      std::vector<std::pair<int, int>> sizes = {{1, 1}, {5, 3}, {131, 7}};
      sizes.emplace_back(raw_width, raw_height);
      for (const auto& [width, height] : sizes) {
        for (const Map& map : maps_for(raw_width, raw_height)) {
          SCOPED_TRACE(std::string(map.name) + ", raw " + std::to_string(raw_width) + "x" + std::to_string(raw_height) + ", to " +
                       std::to_string(width) + "x" + std::to_string(height));
          expect_near_remap(raw, map, width, height);
        }
      }
    }
  }
}

TEST(RectifyPeer, large_images_are_near_remap) {
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{640, 480}, {753, 480}, {1920, 1200}}) {
    const Raw raw(width, height, 0);
    for (const Map& map : maps_for(width, height)) {
      if (width > 1000 && std::string_view(map.name).find("lens") == std::string_view::npos) continue;
      SCOPED_TRACE(std::string(map.name) + " " + std::to_string(width));
      expect_near_remap(raw, map, width, height);
    }
  }
}

TEST(RectifyPeer, scattered_blocks_are_near_remap) {
  std::minstd_rand random(1);
  const Raw raw(1600, 500, 0);
  const Map shaken{"shaken", [&](int x, int y) {
                     const auto noise = static_cast<int>(random() >> 4);
                     return std::pair{x + 3.0 + noise % 3, y + 3.0 + noise / 3 % 4};
                   }};
  expect_near_remap(raw, shaken, 1500, 400);
}

}  // namespace
}  // namespace vdisp::kernels
