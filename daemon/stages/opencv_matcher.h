// opencv_matcher.h: part of `disparity`: OpenCV's matchers behind the same parameters, to be compared with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/calib3d.hpp>

#include "config/config.h"
#include "daemon/stages/floor_check.h"

namespace vdisp {

/// Two gray8 views to disparities with reasons, all filters but that of speckles.
///
/// What the parameters of SVS (paper table 3) become in OpenCV:
///   ndisp, minDisparity      the same
///   corrsize                 StereoBM: window. StereoSGBM: block of corrsize / 2, made odd
///   thresh                   as in block_matcher.h
///   unique                   uniquenessRatio
///   left/right check         StereoBM: the right view is matched too, and has to lead back within 1 px; OpenCV's own check passes what
///                            no other pixel claims, as on a blank sky. StereoSGBM: disp12MaxDiff = 1
class OpenCvMatcher {
 public:
  OpenCvMatcher(Machine& machine, const Config& config);
  void prepare(const ImageSpec& spec) { floor_check_.prepare(spec); }
  void match(const Image& left, const Image& right, Image& out) noexcept;

 private:
  void set_parameters();
  int16_t none() const;
  int right_border() const;
  void match_right(const cv::Mat& left, const cv::Mat& right);
  void measure_texture(const cv::Mat& left);
  void name_rejected(cv::Mat& disparity) const;
  void check_left_right(cv::Mat& disparity) const;

  const Config& config_;
  cv::Ptr<cv::StereoBM> block_;  // one of the two is set
  cv::Ptr<cv::StereoSGBM> global_;
  cv::Mat left_mirrored_, right_mirrored_, from_right_;  // from_right_ is mirrored too
  cv::Mat gradient_, texture_;
  FloorCheck floor_check_;
};

}  // namespace vdisp
