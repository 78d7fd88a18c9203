// opencv_stages.h: the peers: OpenCV's steps as stages of the same tree, on the same images, with the settings the gates name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/calib3d.hpp>

#include "daemon/core/processor.h"
#include "daemon/geometry/calibration.h"
#include "daemon/stages/rectify.h"
#include "tests/bench/frames.h"

namespace vdisp::bench {

/// cv::remap by 16SC2 tables. gray8 to gray8.
class CvRectify final : public ImageFilter {
 public:
  CvRectify(Side side, const Calibration& calibration) : side_(side), calibration_(calibration) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Side side_;
  Calibration calibration_;
  cv::Mat whole_, fraction_;
};

/// Regions smaller than 100 px go, neighbours of one region differ by 1 px at most: speckle 100 / 1. StereoSGBM's speckleRange is in
/// pixels, StereoBM's in 1/16 px (1 would leave hardly anything), so StereoBM is followed by the filter itself.
inline constexpr int speckle_size = 100, speckle_diff = 16;

enum class Filters { all, no_speckle };

/// StereoBM, window 11, x-Sobel cap 31, texture 10, uniqueness 10, disp12MaxDiff 1; then the speckle filter. Two gray8 to disparity16;
/// what is rejected is -16.
class CvBlockMatcher final : public BinaryOperator {
 public:
  CvBlockMatcher(int ndisp, Filters filters);
  ImageSpec accept(const ImageSpec& left, const ImageSpec& right) override;
  bool combine(const Image& left, const Image& right, Image& out) noexcept override;

 private:
  cv::Ptr<cv::StereoBM> matcher_;
  Filters filters_;
  cv::Mat work_;
};

/// StereoSGBM, MODE_SGBM_3WAY, block 5, P1 200, P2 800, cap 63, uniqueness 10, disp12MaxDiff 1, speckle 100 / 1.
class CvSemiGlobal final : public BinaryOperator {
 public:
  explicit CvSemiGlobal(int ndisp);
  ImageSpec accept(const ImageSpec& left, const ImageSpec& right) override;
  bool combine(const Image& left, const Image& right, Image& out) noexcept override;

 private:
  cv::Ptr<cv::StereoSGBM> matcher_;
};

/// What StereoBM makes of each pair: input of the steps behind a matcher.
std::vector<Set> disparities(const Frames& frames, int ndisp, Filters filters);

cv::Mat mat(const Image& image, int type);

}  // namespace vdisp::bench
