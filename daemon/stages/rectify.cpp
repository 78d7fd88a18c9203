// rectify.cpp: the kernel's table is made once from the calibration; each frame is two kernels at most.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/rectify.h"

#include <cstring>
#include <opencv2/calib3d.hpp>

namespace vdisp {
namespace {

constexpr int least_band = 32;  // rows

std::string size(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

template <class T>
kernels::Plane<T> plane_of(T* pixels, const ImageSpec& spec) {
  return {pixels, spec.width, spec.height, static_cast<ptrdiff_t>(spec.stride())};
}

std::optional<kernels::Bayer> bayer_of(const std::string& word) {
  using kernels::Bayer;
  if (word == "rggb") return Bayer::rggb;
  if (word == "bggr") return Bayer::bggr;
  if (word == "grbg") return Bayer::grbg;
  if (word == "gbrg") return Bayer::gbrg;
  return std::nullopt;
}

/// Where each pixel of a rectified image comes from in the raw one.
kernels::RectifyTable make_table(const RawCamera& camera, const ImageSpec& spec) {
  const cv::Mat k(3, 3, CV_64F, const_cast<double*>(camera.k.data()));
  const cv::Mat distortion(1, 8, CV_64F, const_cast<double*>(camera.distortion.data()));
  const cv::Mat rotation(3, 3, CV_64F, const_cast<double*>(camera.rectification.data()));
  const cv::Mat projection(3, 4, CV_64F, const_cast<double*>(camera.projection.data()));
  cv::Mat whole, part;
  cv::initUndistortRectifyMap(k, distortion, rotation, projection, {spec.width, spec.height}, CV_16SC2, whole, part);
  return {{whole.ptr<int16_t>(), 2 * whole.cols, whole.rows, static_cast<ptrdiff_t>(whole.step1())},
          {part.ptr<uint16_t>(), part.cols, part.rows, static_cast<ptrdiff_t>(part.step1())},
          plane_of<const uint8_t>(nullptr, spec)};
}

}  // namespace

Rectify::Rectify(Side side, std::optional<Calibration> calibration, Machine& machine, const Config& config)
    : side_(side), calibration_(std::move(calibration)), machine_(machine), config_(config), bayer_(bayer_of(config.image_source.bayer)) {}

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
    table_ = make_table((*c.raw)[static_cast<size_t>(side_)], in);
    if (bayer_) grey_.resize(static_cast<size_t>(in.stride()) * in.height);
  }
  return in;
}

bool Rectify::filter(const Image& in, Image& out) noexcept {
  out.camera = geometry_;
  out.calibration_hash = calibration_ ? calibration_->hash : 0;
  const auto target = plane_of(out.row<uint8_t>(0), out.spec);
  kernels::View8 raw = plane_of(in.row<uint8_t>(0), in.spec);
  if (bayer_) {
    const auto grey = table_.empty() ? target : plane_of(grey_.data(), in.spec);
    machine_.bands.run(raw.height, least_band,
                       [&](int first, int last, int) { machine_.kernels.debayer(raw, *bayer_, first, last, grey); });
    raw = grey;
  }
  if (!table_.empty()) {
    machine_.bands.run(raw.height, least_band,
                       [&](int first, int last, int) { machine_.kernels.rectify(table_, raw, first, last, target); });
  } else if (!bayer_) {
    std::memcpy(target.data, raw.data, static_cast<size_t>(raw.stride) * in.spec.height);
  }
  return true;
}

}  // namespace vdisp
