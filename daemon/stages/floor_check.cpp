// floor_check.cpp: two explanations of each pixel, the match and the floor, compared over the window.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/floor_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int cap = 31;         // of the gradient, as in StereoBM
constexpr int near_floor = 24;  // 1/16 px: a match this near to the floor's disparity is the floor
constexpr int above_horizon = INT32_MIN;
constexpr float as_well = 1.5f;  // the floor may fit this much worse and still explain the pixel

void signed_gradient(const cv::Mat& view, cv::Mat& work, cv::Mat& out) {
  cv::Sobel(view, work, CV_16S, 1, 0, 3);
  cv::max(work, -cap, work);
  cv::min(work, cap, work);
  work.convertTo(out, CV_8U, 1, cap);
}

/// |left[u] - right[u - shift]|, shift in 1/16 px, the right row interpolated; `cap` where that lies outside.
inline uint8_t difference(const uint8_t* left, const uint8_t* right, int u, int shift, int columns) {
  const int x = 16 * u - shift, whole = x >> 4, part = x & 15;
  if (whole < 0 || whole + 1 >= columns) return cap;
  const int value = (right[whole] * (16 - part) + right[whole + 1] * part + 8) >> 4;
  return static_cast<uint8_t>(std::abs(left[u] - value));
}

}  // namespace

FloorCheck::FloorCheck(Machine& machine, const Config& config) : config_(config), provisional_(machine, config) {}

void FloorCheck::prepare(const ImageSpec& disparity) {
  provisional_.prepare(disparity);
  shift_.resize(disparity.height);
  off_floor_.create(disparity.height, disparity.width, CV_8U);
  off_match_.create(disparity.height, disparity.width, CV_8U);
}

bool FloorCheck::find_floor(const Image& disparity) noexcept {
  const FloorModel* found = provisional_.find(disparity);
  if (!found) return false;
  for (size_t v = 0; v < shift_.size(); ++v) {
    const double true_d = (static_cast<double>(v) - found->b) / (16 * found->a);
    shift_[v] = true_d > 0 ? static_cast<int>(std::lround(16 * (true_d + static_cast<double>(disparity.camera.cx_offset)))) : above_horizon;
  }
  return true;
}

void FloorCheck::measure(const cv::Mat& left, const cv::Mat& right, const Image& disparity) noexcept {
  signed_gradient(left, gradient_, left_gradient_);
  signed_gradient(right, gradient_, right_gradient_);
  for (int v = 0; v < left.rows; ++v) {
    const uint8_t *l = left_gradient_.ptr(v), *r = right_gradient_.ptr(v);
    const int16_t* d = disparity.row<int16_t>(v);
    uint8_t *by_floor = off_floor_.ptr(v), *by_match = off_match_.ptr(v);
    const int floor = shift_[static_cast<size_t>(v)];
    for (int u = 0; u < left.cols; ++u) {
      by_floor[u] = floor == above_horizon ? cap : difference(l, r, u, floor, left.cols);
      by_match[u] = rejected_code(d[u]) ? cap : difference(l, r, u, d[u], left.cols);
    }
  }
  const int window = config_.image_source.corrsize;
  cv::boxFilter(off_floor_, floor_cost_, CV_32S, {window, window}, {-1, -1}, false);
  cv::boxFilter(off_match_, match_cost_, CV_32S, {window, window}, {-1, -1}, false);
}

void FloorCheck::refuse(const cv::Mat& left, const cv::Mat& right, Image& disparity) noexcept {
  if (!find_floor(disparity)) return;
  measure(left, right, disparity);
  for (int v = 0; v < disparity.spec.height; ++v) {
    const int floor = shift_[static_cast<size_t>(v)];
    if (floor == above_horizon) continue;
    int16_t* d = disparity.row<int16_t>(v);
    const int32_t *by_floor = floor_cost_.ptr<int32_t>(v), *by_match = match_cost_.ptr<int32_t>(v);
    for (int u = 0; u < disparity.spec.width; ++u) {
      if (rejected_code(d[u]) || std::abs(d[u] - floor) <= near_floor) continue;
      if (static_cast<float>(by_floor[u]) < as_well * static_cast<float>(by_match[u])) d[u] = rejected(Rejected::not_unique);
    }
  }
}

}  // namespace vdisp
