// disparity.cpp: one of the matchers, told where the floor is expected, and the filter of speckles behind it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/disparity.h"

#include <algorithm>

namespace vdisp {
Disparity::Disparity(Machine& machine, const Config& config) : config_(config), expectation_(config) {
  if (config.image_source.matcher == "bm") {
    block_.emplace(machine, config);
  } else {
    opencv_.emplace(config);
  }
}

std::vector<ImageSpec> Disparity::check(std::span<const ImageSpec> in) {
  if (in.size() != 2 && in.size() != 3) throw FormatError("takes the two views and the last floor model, was given " + std::to_string(in.size()) + " images");
  const ImageSpec &left = in[0], &right = in[1];
  require(left, Pixel::gray8, "the left image");
  require(right, Pixel::gray8, "the right image");
  require_same_size(left, right);
  if (in.size() == 3) require(in[2], Pixel::record, "the last floor model");
  const auto& p = config_.image_source;
  const int search = p.ndisp + std::max(p.minDisparity, 0) + p.corrsize;
  if (left.width <= search)
    throw FormatError("the images are " + std::to_string(left.width) + " columns wide, ndisp + minDisparity + corrsize = " +
                      std::to_string(search) + " leaves none to search; a smaller ndisp would fit");
  if (left.height <= p.corrsize)
    throw FormatError("the images have " + std::to_string(left.height) + " rows, the window corrsize needs more than " +
                      std::to_string(p.corrsize));
  const ImageSpec out{Pixel::disparity16, 0, left.width, left.height};
  if (block_) block_->prepare(out);
  if (opencv_) opencv_->prepare(out);
  return {out};
}

Outcome Disparity::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  Image& disparity = *out[0];
  disparity.camera.min_disparity = config_.image_source.minDisparity;
  disparity.camera.disparities = config_.image_source.ndisp;
  if (block_) {
    const FloorModel* last = in.size() == 3 && in[2]->valid() ? record_of<FloorModel>(*in[2]) : nullptr;
    std::optional<ExpectedFloor> floor;
    if (config_.image_source.align == "floor") floor = expectation_.expect(disparity, last);
    block_->match(*in[0], *in[1], floor ? &*floor : nullptr, disparity);
  } else {
    opencv_->match(*in[0], *in[1], disparity);
  }
  refuse_speckles(disparity);
  return Outcome::valid;
}

void Disparity::refuse_speckles(Image& out) noexcept {
  const auto& p = config_.image_source;
  if (p.SpeckleSize == 0) return;
  cv::Mat disparity(out.spec.height, out.spec.width, CV_16S, out.row<int16_t>(0), out.spec.stride());
  const int16_t none = static_cast<int16_t>((p.minDisparity - 1) * 16);
  disparity.copyTo(before_);
  // The filter takes every value but `newVal` for a disparity: what is rejected already must not make regions.
  disparity.setTo(none, disparity < rejected_base);
  cv::filterSpeckles(disparity, none, p.SpeckleSize, p.SpeckleDiff * 4, speckles_);
  for (int v = 0; v < disparity.rows; ++v) {
    int16_t* d = disparity.ptr<int16_t>(v);
    const int16_t* before = before_.ptr<int16_t>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      if (d[u] == none) d[u] = rejected_code(before[u]) ? before[u] : rejected(Rejected::speckle);
    }
  }
}

}  // namespace vdisp
