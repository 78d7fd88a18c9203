// disparity.h: stage `disparity`: for each pixel of the left view how far it lies displaced in the right one, or why that is not known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/calib3d.hpp>

#include "config/config.h"
#include "daemon/core/processor.h"

namespace vdisp {

/// Two gray8 of one size to disparity16 (1/16 px). Nothing else in the program knows which matcher it stands on.
///
/// What the parameters of SVS (paper table 3) become in OpenCV:
///   ndisp, minDisparity          the same                     the same
///   corrsize                     StereoBM window              StereoSGBM block corrsize / 2, made odd
///   thresh                       textureThreshold = thresh * corrsize^2 / 2, so that the same number means the same contrast
///                                whatever the window          (no such filter)
///   unique                       uniquenessRatio              uniquenessRatio
///   left/right check             disp12MaxDiff = 1            disp12MaxDiff = 1
///   SpeckleSize, SpeckleDiff     cv::filterSpeckles with maxDiff = SpeckleDiff / 4 px, for both
class Disparity final : public BinaryOperator {
 public:
  explicit Disparity(const Config& config);
  ImageSpec accept(const ImageSpec& left, const ImageSpec& right) override;
  bool combine(const Image& left, const Image& right, Image& out) noexcept override;

 private:
  void set_parameters();
  void measure_texture(const cv::Mat& left);
  void name_reasons(cv::Mat& disparity) const;

  const Config& config_;
  cv::Ptr<cv::StereoBM> block_;  // one of the two is set
  cv::Ptr<cv::StereoSGBM> global_;
  cv::Mat matched_;   // before the speckle filter
  cv::Mat speckles_;  // work space of the speckle filter
  cv::Mat gradient_, texture_;
};

}  // namespace vdisp
