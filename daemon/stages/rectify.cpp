// rectify.cpp: OpenCV's fixed-point remap by tables made once from the calibration.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/rectify.h"

#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace vdisp {
namespace {

std::string size(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

cv::Mat view_of(const Image& image) {
  return {image.spec.height, image.spec.width, CV_8U, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()};
}

}  // namespace

Rectify::Rectify(Side side, std::optional<Calibration> calibration, Machine& machine, const Config& config)
    : side_(side), calibration_(std::move(calibration)), machine_(machine), config_(config) {}

ImageSpec Rectify::accept(const ImageSpec& in) {
  require(in, Pixel::gray8, "the camera image");
  const auto& wanted = config_.image_source;
  if ((wanted.width && wanted.width != in.width) || (wanted.height && wanted.height != in.height))
    throw FormatError("the images are " + size(in.width, in.height) + ", [image source] asks for " + size(wanted.width, wanted.height));
  if (!calibration_) return in;

  const Calibration& c = *calibration_;
  if (c.width && (c.width != in.width || c.height != in.height))
    throw FormatError("the images are " + size(in.width, in.height) + ", the calibration (" + c.format + ") is for " +
                      size(c.width, c.height));
  geometry_ = {static_cast<float>(c.view.f),
               static_cast<float>(c.view.cx),
               static_cast<float>(c.view.cy),
               static_cast<float>(c.view.baseline),
               static_cast<float>(c.view.cx_offset),
               0,
               0,
               {}};
  if (c.raw) {
    const RawCamera& camera = (*c.raw)[static_cast<size_t>(side_)];
    const cv::Mat k(3, 3, CV_64F, const_cast<double*>(camera.k.data()));
    const cv::Mat distortion(1, 8, CV_64F, const_cast<double*>(camera.distortion.data()));
    const cv::Mat rotation(3, 3, CV_64F, const_cast<double*>(camera.rectification.data()));
    const cv::Mat projection(3, 4, CV_64F, const_cast<double*>(camera.projection.data()));
    cv::initUndistortRectifyMap(k, distortion, rotation, projection, {in.width, in.height}, CV_16SC2, whole_, fraction_);
  }
  return in;
}

bool Rectify::filter(const Image& in, Image& out) noexcept {
  out.camera = geometry_;
  out.calibration_hash = calibration_ ? calibration_->hash : 0;
  if (whole_.empty()) {
    std::memcpy(out.row<uint8_t>(0), in.row<uint8_t>(0), static_cast<size_t>(in.spec.stride()) * in.spec.height);
  } else {
    cv::Mat target = view_of(out);
    cv::remap(view_of(in), target, whole_, fraction_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  }
  return true;
}

}  // namespace vdisp
