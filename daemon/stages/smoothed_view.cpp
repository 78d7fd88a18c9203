// smoothed_view.cpp: both steps by bands of rows.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/smoothed_view.h"

#include <cstring>

#include "daemon/snow/encoding.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int least_band = 32;  // rows: joining bands has its price too

}  // namespace

ImageSpec SmoothedView::accept(const ImageSpec& in) {
  require(in, Pixel::gray8, "the view");
  const int scale = config_.census.scale;
  const ImageSpec out{Pixel::gray8, 0, static_cast<uint16_t>(in.width / scale), static_cast<uint16_t>(in.height / scale)};
  if (out.width < snow::columns || out.height < snow::rows)
    throw FormatError("the view of " + std::to_string(in.width) + "x" + std::to_string(in.height) +
                      " with [census] scale = " + std::to_string(scale) + " becomes " + std::to_string(out.width) + "x" +
                      std::to_string(out.height) + ", must be 80x60 or more; a smaller scale would fit");
  small_.emplace(out);
  return out;
}

bool SmoothedView::filter(const Image& in, Image& out) noexcept {
  const int scale = config_.census.scale;
  const auto& k = machine_.kernels;
  const auto& word = config_.census.smooth;
  if (in.camera.f > 0) {
    const float s = static_cast<float>(scale), half = (s - 1) / 2;  // of a pixel of the view, to the middle of the new one
    CameraGeometry& g = out.camera;
    g.f /= s;
    g.cx = (g.cx - half) / s;
    g.cy = (g.cy - half) / s;
    g.cx_offset /= s;
  }
  const bool smooths = word != "none";
  Image& small = smooths && scale > 1 ? small_->loan() : out;
  if (scale > 1) {
    machine_.bands.run(out.spec.height, least_band,
                       [&](int first, int last, int) { k.shrink(plane<uint8_t>(in), scale, first, last, plane<uint8_t>(small)); });
  } else if (!smooths) {
    for (int y = 0; y < out.spec.height; ++y) std::memcpy(out.row<uint8_t>(y), in.row<uint8_t>(y), out.spec.width);
  }
  if (!smooths) return true;
  const kernels::View8 view = scale > 1 ? plane<uint8_t>(static_cast<const Image&>(small)) : plane<uint8_t>(in);
  const auto smooth = word == "mean" ? k.mean3x3 : k.median3x3;
  machine_.bands.run(out.spec.height, least_band, [&](int first, int last, int) { smooth(view, first, last, plane<uint8_t>(out)); });
  return true;
}

}  // namespace vdisp
