// opencv_stages.cpp: thin wrappers; results are written where the stage's output lies.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/opencv_stages.h"

#include <opencv2/imgproc.hpp>

namespace vdisp::bench {
namespace {

constexpr int window = 11, texture = 10, uniqueness = 10;

ImageSpec disparity_of(const ImageSpec& view) { return {Pixel::disparity16, 0, view.width, view.height}; }

void describe(Image& out, int ndisp) {
  out.camera.min_disparity = 0;
  out.camera.disparities = ndisp;
}

}  // namespace

cv::Mat mat(const Image& image, int type) {
  return {image.spec.height, image.spec.width, type, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()};
}

ImageSpec CvRectify::accept(const ImageSpec& in) {
  const RawCamera& camera = calibration_.raw.value()[static_cast<size_t>(side_)];
  const cv::Mat k(3, 3, CV_64F, const_cast<double*>(camera.k.data()));
  const cv::Mat distortion(1, 8, CV_64F, const_cast<double*>(camera.distortion.data()));
  const cv::Mat rotation(3, 3, CV_64F, const_cast<double*>(camera.rectification.data()));
  const cv::Mat projection(3, 4, CV_64F, const_cast<double*>(camera.projection.data()));
  cv::initUndistortRectifyMap(k, distortion, rotation, projection, {in.width, in.height}, CV_16SC2, whole_, fraction_);
  return in;
}

bool CvRectify::filter(const Image& in, Image& out) noexcept {
  const StereoView& view = calibration_.view;
  out.camera.f = static_cast<float>(view.f);
  out.camera.cx = static_cast<float>(view.cx);
  out.camera.cy = static_cast<float>(view.cy);
  out.camera.baseline = static_cast<float>(view.baseline);
  out.camera.cx_offset = static_cast<float>(view.cx_offset);
  cv::Mat target = mat(out, CV_8U);
  cv::remap(mat(in, CV_8U), target, whole_, fraction_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return true;
}

CvBlockMatcher::CvBlockMatcher(int ndisp, Filters filters) : matcher_(cv::StereoBM::create(ndisp, window)), filters_(filters) {
  matcher_->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
  matcher_->setPreFilterCap(31);
  matcher_->setTextureThreshold(texture);
  matcher_->setUniquenessRatio(uniqueness);
  matcher_->setDisp12MaxDiff(1);
}

ImageSpec CvBlockMatcher::accept(const ImageSpec& left, const ImageSpec&) { return disparity_of(left); }

bool CvBlockMatcher::combine(const Image& left, const Image& right, Image& out) noexcept {
  describe(out, matcher_->getNumDisparities());
  cv::Mat disparity = mat(out, CV_16S);
  matcher_->compute(mat(left, CV_8U), mat(right, CV_8U), disparity);
  if (filters_ == Filters::all) cv::filterSpeckles(disparity, -16, speckle_size, speckle_diff, work_);
  return true;
}

CvSemiGlobal::CvSemiGlobal(int ndisp)
    : matcher_(cv::StereoSGBM::create(0, ndisp, 5, 200, 800, 1, 63, uniqueness, speckle_size, speckle_diff / 16,
                                      cv::StereoSGBM::MODE_SGBM_3WAY)) {}

ImageSpec CvSemiGlobal::accept(const ImageSpec& left, const ImageSpec&) { return disparity_of(left); }

bool CvSemiGlobal::combine(const Image& left, const Image& right, Image& out) noexcept {
  describe(out, matcher_->getNumDisparities());
  cv::Mat disparity = mat(out, CV_16S);
  matcher_->compute(mat(left, CV_8U), mat(right, CV_8U), disparity);
  return true;
}

std::vector<Set> disparities(const Frames& frames, int ndisp, Filters filters) {
  std::vector<Set> sets;
  CvBlockMatcher matcher(ndisp, filters);
  for (const Set& views : frames.rectified) {
    std::vector<std::unique_ptr<Picture>> out;
    run_stage(matcher, {views[0].get(), views[1].get()}, out);
    sets.push_back({std::move(out.at(0))});
  }
  return sets;
}

}  // namespace vdisp::bench
