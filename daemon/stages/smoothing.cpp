// smoothing.cpp: mean or median by bands of rows.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/smoothing.h"

namespace vdisp {
namespace {

constexpr int least_band = 32;  // rows: joining bands has its price too

kernels::Plane<uint8_t> plane_of(Image& image) {
  return {image.row<uint8_t>(0), image.spec.width, image.spec.height, static_cast<ptrdiff_t>(image.spec.stride())};
}

kernels::View8 view_of(const Image& image) {
  return {image.row<uint8_t>(0), image.spec.width, image.spec.height, static_cast<ptrdiff_t>(image.spec.stride())};
}

}  // namespace

void Smoothing::prepare(const ImageSpec& spec) {
  for (auto& outlet : smoothed_) outlet.emplace(ImageSpec{Pixel::gray8, 0, spec.width, spec.height});
}

std::array<const Image*, 2> Smoothing::smooth(const Image& left, const Image& right) noexcept {
  const auto& word = config_.image_source.smooth;
  if (word == "none") return {&left, &right};
  const auto filter = word == "mean" ? machine_.kernels.mean3x3 : machine_.kernels.median3x3;
  const std::array<const Image*, 2> in{&left, &right};
  const std::array<Image*, 2> out{&smoothed_[0]->loan(), &smoothed_[1]->loan()};
  for (size_t i = 0; i < in.size(); ++i) out[i]->describe_like(*in[i]);
  machine_.bands.run(left.spec.height, least_band, [&](int first, int last, int) {
    for (size_t i = 0; i < in.size(); ++i) filter(view_of(*in[i]), first, last, plane_of(*out[i]));
  });
  return {out[0], out[1]};
}

}  // namespace vdisp
