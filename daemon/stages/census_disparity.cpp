// census_disparity.cpp: the search by bands of rows, and a look whether there was anything to see.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/census_disparity.h"

#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int dark = 14, bright = 250;  // grey levels
constexpr double most_bright = 0.7;     // share of the pixels
constexpr double least_matched = 0.01;  // likewise

}  // namespace

std::vector<ImageSpec> CensusDisparity::check(std::span<const ImageSpec> in) {
  if (in.size() != 3) throw FormatError("takes both census images and the left view, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::gray8, "the left census image");
  require(in[1], Pixel::gray8, "the right census image");
  require(in[2], Pixel::gray8, "the left view");
  require_same_size(in[0], in[1]);
  require_same_size(in[0], in[2]);
  const auto& p = config_.census;
  if (in[0].width <= p.width + p.block || in[0].height <= p.block)
    throw FormatError("the images are " + std::to_string(in[0].width) + "x" + std::to_string(in[0].height) +
                      ", [census] width = " + std::to_string(p.width) + " with block = " + std::to_string(p.block) +
                      " leaves none to search; a smaller width, block or scale would fit");
  bands_.assign(static_cast<size_t>(machine_.bands.threads()), kernels::HammingScratch(in[0].width, p.width));
  return {{Pixel::disparity16, 0, in[0].width, in[0].height}};
}

Outcome CensusDisparity::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  constexpr int least_band = 48;  // rows: each band begins with a window of them
  const auto& p = config_.census;
  Image& disparity = *out[0];
  disparity.camera.min_disparity = 0;
  disparity.camera.disparities = p.width;
  const kernels::HammingSearch search{.left = plane<uint8_t>(*in[0]),
                                      .right = plane<uint8_t>(*in[1]),
                                      .window = p.block,
                                      .disparities = p.width,
                                      .confidence = static_cast<int>(std::lround(p.confidence * p.width * p.block * p.block)),
                                      .refused = rejected(Rejected::low_texture),
                                      .outside = rejected(Rejected::outside)};
  machine_.bands.run(disparity.spec.height, least_band, [&](int first, int last, int band) {
    machine_.kernels.match_hamming(search, first, last, bands_[static_cast<size_t>(band)], plane<int16_t>(disparity));
  });
  disparity.reason = blindness(*in[2], disparity);
  return disparity.reason == Reason::none ? Outcome::valid : Outcome::invalid;
}

Reason CensusDisparity::blindness(const Image& view, const Image& disparity) const noexcept {
  constexpr int step = 4;
  size_t all = 0, sum = 0, full = 0, matched = 0;
  for (int v = step / 2; v < view.spec.height; v += step) {
    const uint8_t* grey = view.row<uint8_t>(v);
    const int16_t* d = disparity.row<int16_t>(v);
    for (int u = v / step % 2 * step / 2; u < view.spec.width; u += step) {
      ++all;
      sum += grey[u];
      full += grey[u] >= bright;
      matched += d[u] > 0;
    }
  }
  const double n = static_cast<double>(all);
  if (static_cast<double>(sum) < dark * n) return Reason::too_dark;
  if (static_cast<double>(full) > most_bright * n) return Reason::too_bright;
  return static_cast<double>(matched) < least_matched * n ? Reason::no_texture : Reason::none;
}

}  // namespace vdisp
