// disparity.cpp: one of the matchers, told where the floor is expected, and the filter of speckles behind it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/disparity.h"

#include <algorithm>

namespace vdisp {
namespace {

/// Keys that another matcher would have read.
void require_supported(const Config& config) {
  const auto& p = config.image_source;
  if (p.prefilter != "sobel" && p.matcher != "bm")
    throw FormatError("prefilter = " + p.prefilter + " is for matcher = bm, and the matcher is " + p.matcher +
                      "; prefilter = sobel, or none in the file, would fit");
  if (p.census != "3x3" && p.matcher != "census")
    throw FormatError("census = " + p.census + " is for matcher = census, and the matcher is " + p.matcher +
                      "; census = 3x3, or none in the file, would fit");
  if (p.paths != "3" && p.matcher != "sgm")
    throw FormatError("paths = " + p.paths + " is for matcher = sgm, and the matcher is " + p.matcher +
                      "; paths = 3, or none in the file, would fit");
}

}  // namespace

Disparity::Disparity(Machine& machine, const Config& config)
    : machine_(machine), config_(config), expectation_(config), provisional_(machine, config), smoothing_(machine, config) {
  if (config.image_source.matcher == "bm" || config.image_source.matcher == "census") {
    block_.emplace(machine, config);
  } else if (config.image_source.matcher == "sgm") {
    semi_global_.emplace(machine, config);
  } else {
    opencv_.emplace(machine, config);
  }
}

std::vector<ImageSpec> Disparity::check(std::span<const ImageSpec> in) {
  if (in.size() != 2 && in.size() != 3)
    throw FormatError("takes the two views and the last floor model, was given " + std::to_string(in.size()) + " images");
  const ImageSpec &left = in[0], &right = in[1];
  require(left, Pixel::gray8, "the left image");
  require(right, Pixel::gray8, "the right image");
  require_same_size(left, right);
  if (in.size() == 3) require(in[2], Pixel::record, "the last floor model");
  require_supported(config_);
  const auto& p = config_.image_source;
  if (left.width <= p.corrsize - p.minDisparity)
    throw FormatError("the images are " + std::to_string(left.width) + " columns wide, minDisparity = " + std::to_string(p.minDisparity) +
                      " with corrsize = " + std::to_string(p.corrsize) + " leaves none to search; minDisparity from " +
                      std::to_string(p.corrsize + 1 - left.width) + " on would fit");
  const int search = p.ndisp + std::max(p.minDisparity, 0) + p.corrsize;
  if (left.width <= search)
    throw FormatError("the images are " + std::to_string(left.width) + " columns wide, ndisp + minDisparity + corrsize = " +
                      std::to_string(search) + " leaves none to search; a smaller ndisp would fit");
  if (left.height <= p.corrsize)
    throw FormatError("the images have " + std::to_string(left.height) + " rows, the window corrsize needs more than " +
                      std::to_string(p.corrsize));
  const ImageSpec out{Pixel::disparity16, 0, left.width, left.height};
  expectation_.prepare(out);
  if (block_) block_->prepare(out);
  if (semi_global_) semi_global_->prepare(out);
  if (opencv_) opencv_->prepare(out);
  provisional_.prepare(out);
  smoothing_.prepare(out);
  speckles_.emplace(out.width, out.height);
  return {out};
}

Outcome Disparity::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  Image& disparity = *out[0];
  disparity.camera.min_disparity = config_.image_source.minDisparity;
  disparity.camera.disparities = config_.image_source.ndisp;
  const auto [left, right] = smoothing_.smooth(*in[0], *in[1]);
  if (block_) {
    match_blocks(*left, *right, in.size() == 3 && in[2]->valid() ? record_of<FloorModel>(*in[2]) : nullptr, disparity);
  } else if (semi_global_) {
    semi_global_->match(*left, *right, disparity);
  } else {
    opencv_->match(*left, *right, disparity);
  }
  refuse_speckles(disparity);
  return Outcome::valid;
}

void Disparity::match_blocks(const Image& left, const Image& right, const FloorModel* last, Image& out) noexcept {
  const bool align = config_.image_source.align == "floor";
  std::optional<ExpectedFloor> floor;
  if (align) floor = expectation_.expect(out, last);
  block_->match(left, right, floor ? &*floor : nullptr, out);
  if (!align || (floor && !expectation_.doubtful(out))) return;
  // Nothing is known of the floor but how the camera is mounted, if that: what this first look shows of it serves a second one.
  const FloorModel* seen = provisional_.find(out, left);
  if (!seen) return;
  floor = expectation_.expect(out, seen);
  if (floor) block_->match(left, right, &*floor, out);
}

void Disparity::refuse_speckles(Image& out) noexcept {
  const auto& p = config_.image_source;
  if (p.SpeckleSize == 0) return;
  constexpr int least_band = 64;  // rows: joining bands has its price too
  const auto& k = machine_.kernels;
  const kernels::SpeckleRule rule{rejected_base, rejected(Rejected::speckle), p.SpeckleDiff * 4, p.SpeckleSize};
  const kernels::Plane<int16_t> plane{out.row<int16_t>(0), out.spec.width, out.spec.height,
                                      static_cast<ptrdiff_t>(out.spec.stride() / sizeof(int16_t))};
  machine_.bands.run(plane.height, least_band, [&](int first, int last, int) { k.speckle_label(plane, rule, first, last, *speckles_); });
  k.speckle_join(plane, rule, *speckles_);
  machine_.bands.run(plane.height, least_band, [&](int first, int last, int) { k.speckle_refuse(rule, first, last, *speckles_, plane); });
}

}  // namespace vdisp
