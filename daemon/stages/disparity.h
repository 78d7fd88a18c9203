// disparity.h: stage `disparity`: for each pixel of the left view how far it lies displaced in the right one, or why that is not known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/calib3d.hpp>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/floor_check.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Two gray8 of one size to disparity16 (1/16 px). Nothing else in the program knows which matcher it stands on.
///
/// What the parameters of SVS (paper table 3) become in OpenCV:
///   ndisp, minDisparity      the same
///   corrsize                 StereoBM: window. StereoSGBM: block of corrsize / 2, made odd
///   thresh                   the sum of |x-Sobel|, each at most 31, over the window has to reach thresh * corrsize^2 / 2: the same
///                            number means the same contrast whatever the window, and 10 just refuses noise of 2 grey levels
///   unique                   uniquenessRatio
///   left/right check         StereoBM: the right view is matched too, and has to lead back within 1 px; OpenCV's own check passes what
///                            no other pixel claims, as on a blank sky. StereoSGBM: disp12MaxDiff = 1
///   SpeckleSize, SpeckleDiff cv::filterSpeckles with maxDiff = SpeckleDiff / 4 px
class Disparity final : public BinaryOperator {
 public:
  Disparity(Machine& machine, const Config& config);
  ImageSpec accept(const ImageSpec& left, const ImageSpec& right) override;
  bool combine(const Image& left, const Image& right, Image& out) noexcept override;

 private:
  void set_parameters();
  int16_t none() const;
  int right_border() const;
  void match_right(const cv::Mat& left, const cv::Mat& right);
  void measure_texture(const cv::Mat& left);
  void name_rejected(cv::Mat& disparity) const;
  void check_left_right(cv::Mat& disparity) const;
  void refuse_speckles(cv::Mat& disparity);

  Machine& machine_;
  const Config& config_;
  cv::Ptr<cv::StereoBM> block_;  // one of the two is set
  cv::Ptr<cv::StereoSGBM> global_;
  cv::Mat left_mirrored_, right_mirrored_, from_right_;  // from_right_ is mirrored too
  cv::Mat before_, speckles_;                            // work space of the speckle filter
  cv::Mat gradient_, texture_;
  FloorCheck floor_check_;
};

}  // namespace vdisp
