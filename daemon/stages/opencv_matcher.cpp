// opencv_matcher.cpp: OpenCV's matchers behind SVS's parameters, and the reasons of the rejected pixels.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/opencv_matcher.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace vdisp {
namespace {

constexpr int sobel_cap = 31;  // StereoBM's own: contrast above it counts as this much

cv::Mat mat(const Image& image, int type) {
  return {image.spec.height, image.spec.width, type, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()};
}

}  // namespace

OpenCvMatcher::OpenCvMatcher(Machine& machine, const Config& config) : config_(config), floor_check_(machine, config) {
  if (config.image_source.matcher == "opencv") {
    block_ = cv::StereoBM::create();
    block_->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
    block_->setPreFilterCap(sobel_cap);
  } else {
    global_ = cv::StereoSGBM::create();
    global_->setMode(cv::StereoSGBM::MODE_SGBM_3WAY);
    global_->setPreFilterCap(63);
    global_->setDisp12MaxDiff(1);
  }
  set_parameters();
}

void OpenCvMatcher::set_parameters() {
  const auto& p = config_.image_source;
  if (block_) {
    block_->setNumDisparities(p.ndisp);
    block_->setMinDisparity(p.minDisparity);
    block_->setBlockSize(p.corrsize);
    block_->setTextureThreshold(0);  // asked in name_rejected(), the same for both matchers
    block_->setUniquenessRatio(p.unique);
  } else {
    const int block = (p.corrsize / 2) | 1;
    global_->setNumDisparities(p.ndisp);
    global_->setMinDisparity(p.minDisparity);
    global_->setBlockSize(block);
    global_->setP1(8 * block * block);
    global_->setP2(32 * block * block);
    global_->setUniquenessRatio(p.unique);
  }
}

/// What OpenCV writes where it found nothing.
int16_t OpenCvMatcher::none() const { return static_cast<int16_t>((config_.image_source.minDisparity - 1) * 16); }

void OpenCvMatcher::match(const Image& left, const Image& right, Image& out) noexcept {
  set_parameters();
  cv::Mat result = mat(out, CV_16S);
  const cv::Mat left_view = mat(left, CV_8U), right_view = mat(right, CV_8U);
  if (block_) {
    block_->compute(left_view, right_view, result);
    match_right(left_view, right_view);
  } else {
    global_->compute(left_view, right_view, result);
  }
  measure_texture(left_view);
  name_rejected(result);
  if (block_) check_left_right(result);
  floor_check_.refuse(left_view, right_view, out);
}

/// Seen in a mirror the right view is the left one. StereoBM gives up where the search leaves the image, in the mirror at the right
/// border: the views are continued there by their last column, so that it searches as far as there is something.
void OpenCvMatcher::match_right(const cv::Mat& left, const cv::Mat& right) {
  const int beyond = right_border();
  for (const auto& [view, mirrored] : {std::pair{&left, &left_mirrored_}, std::pair{&right, &right_mirrored_}}) {
    mirrored->create(view->rows, view->cols + beyond, CV_8U);
    cv::Mat inside = mirrored->colRange(beyond, mirrored->cols);
    cv::flip(*view, inside, 1);
    for (int v = 0; v < view->rows; ++v) std::fill_n(mirrored->ptr(v), beyond, view->ptr(v)[view->cols - 1]);
  }
  block_->compute(right_mirrored_, left_mirrored_, from_right_);
}

int OpenCvMatcher::right_border() const {
  const auto& p = config_.image_source;
  return std::max(p.ndisp + p.minDisparity, 0) + p.corrsize;
}

/// The sum over the window that thresh is compared with.
void OpenCvMatcher::measure_texture(const cv::Mat& left) {
  cv::Sobel(left, gradient_, CV_16S, 1, 0, 3);
  cv::convertScaleAbs(gradient_, gradient_);
  cv::min(gradient_, sobel_cap, gradient_);
  const int window = config_.image_source.corrsize;
  cv::boxFilter(gradient_, texture_, CV_32S, {window, window}, {-1, -1}, false);
}

/// Replaces OpenCV's one value for "nothing" by the reason, and refuses what has too little texture to be trusted.
void OpenCvMatcher::name_rejected(cv::Mat& disparity) const {
  const auto& p = config_.image_source;
  const int threshold = p.thresh * p.corrsize * p.corrsize / 2;
  // What no window or search can reach. Semi-global matching has no window to speak of, but the same search.
  const int border = block_ ? p.corrsize / 2 : 0;
  const int left = border + std::max(p.minDisparity + p.ndisp - 1, 0);
  const int right = disparity.cols - border + std::min(p.minDisparity, 0);
  for (int v = 0; v < disparity.rows; ++v) {
    int16_t* d = disparity.ptr<int16_t>(v);
    const int32_t* texture = texture_.ptr<int32_t>(v);
    const bool row_outside = v < border || v >= disparity.rows - border;
    for (int u = 0; u < disparity.cols; ++u) {
      if (d[u] <= none() && (row_outside || u < left || u >= right)) {
        d[u] = rejected(Rejected::outside);
      } else if (texture[u] < threshold) {
        d[u] = rejected(Rejected::low_texture);
      } else if (d[u] <= none()) {
        // Of block matching only the uniqueness filter is left; StereoSGBM does not say which of its two it was.
        d[u] = rejected(block_ ? Rejected::not_unique : Rejected::matcher);
      }
    }
  }
}

void OpenCvMatcher::check_left_right(cv::Mat& disparity) const {
  const int columns = disparity.cols, mirror = right_border() + columns - 1;
  for (int v = 0; v < disparity.rows; ++v) {
    int16_t* d = disparity.ptr<int16_t>(v);
    const int16_t* back = from_right_.ptr<int16_t>(v);
    for (int u = 0; u < columns; ++u) {
      if (rejected_code(d[u])) continue;
      const int there = u - ((d[u] + 8) >> 4);
      const bool seen = there >= 0 && there < columns;
      // What the right view could not match itself is not confirmed either.
      if (!seen || std::abs(back[mirror - there] - d[u]) > 16) d[u] = rejected(Rejected::left_right);
    }
  }
}

}  // namespace vdisp
