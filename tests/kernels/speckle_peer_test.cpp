// speckle_peer_test.cpp: the speckle filter refuses the pixels that cv::filterSpeckles refuses.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "tests/kernels/speckle_pictures.h"

namespace vdisp::kernels {
namespace {

Picture<int16_t> by_opencv(const Picture<int16_t>& in, const SpeckleRule& rule) {
  Picture<int16_t> out = in;
  const Plane<int16_t> p = out.plane();
  cv::Mat image(p.height, p.width, CV_16S), work;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) image.at<int16_t>(y, x) = std::max<int16_t>(p.row(y)[x], none);
  cv::filterSpeckles(image, none, rule.max_size, rule.max_difference, work);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      if (p.row(y)[x] >= rule.least && image.at<int16_t>(y, x) == none) p.row(y)[x] = rule.refused;
  return out;
}

void expect_as_opencv(const Kernels& k, int width, int height, SpeckleScratch& scratch) {
  for (const auto& [name, pattern] : patterns(width, height)) {
    const Picture<int16_t> in = picture(width, height, pattern);
    for (const auto& [max_size, max_difference] : rules_for(width * height)) {
      const SpeckleRule rule{least, refused, max_difference, max_size};
      const Picture<int16_t> expected = by_opencv(in, rule);
      for (const std::vector<int>& cuts : cuts_of(height)) {
        Picture<int16_t> got = in;
        filter(k, rule, cuts, scratch, got.plane());
        ASSERT_EQ(expected, got) << name << " " << width << "x" << height << " size " << max_size << " difference " << max_difference
                                 << " in " << cuts.size() + 1 << " bands";
      }
    }
  }
}

void check_sizes(const Kernels& k) {
  for (const auto& sizes : {awkward_sizes, larger_sizes}) {
    for (const auto& [width, height] : sizes) {
      SpeckleScratch scratch(width, height);
      expect_as_opencv(k, width, height, scratch);
    }
  }
}

TEST(SpecklePeer, every_level_refuses_what_opencv_refuses) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    check_sizes(kernels(level));
  }
}

TEST(SpecklePeer, nothing_overflows_at_1920x1200) {
  constexpr int width = 1920, height = 1200;
  SpeckleScratch scratch(width, height);
  const SpeckleRule rule{least, refused, 16, 100};
  for (const auto& [name, pattern] : patterns(width, height)) {
    const Picture<int16_t> in = picture(width, height, pattern);
    const Picture<int16_t> expected = by_opencv(in, rule);
    for (const auto& [level, cuts] : {std::pair{"plain", std::vector<int>{}}, {"auto", {300, 301, 900}}}) {
      Picture<int16_t> got = in;
      filter(kernels(level), rule, cuts, scratch, got.plane());
      ASSERT_EQ(expected, got) << name << " " << level;
    }
  }
}

}  // namespace
}  // namespace vdisp::kernels
