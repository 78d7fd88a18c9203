// features.cpp: the room daemon/snow knows the encodings.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/features.h"

namespace vdisp {

snow::Settings front_end(const Config& config, const ImageSpec& view) {
  const auto& p = config.census;
  snow::Settings settings;
  settings.encoding = snow::encoding_named(p.encoding).value_or(snow::Encoding::depth_map);  // the schema knows no other words
  settings.width = view.width;
  settings.height = view.height;
  settings.disparities = static_cast<uint32_t>(p.width);
  settings.block = static_cast<uint32_t>(p.block);
  settings.smooth = p.smooth == "mean" ? snow::Smooth::mean : p.smooth == "median" ? snow::Smooth::median : snow::Smooth::none;
  settings.confidence = p.confidence;
  return settings;
}

ImageSpec Features::accept(const ImageSpec& disparity, const ImageSpec& depth_map) {
  require(disparity, Pixel::disparity16, "the disparity");
  require(depth_map, Pixel::count16, "the depth map");
  if (depth_map.width != disparity.width)
    throw FormatError("the disparity has " + std::to_string(disparity.width) + " columns and the depth map " +
                      std::to_string(depth_map.width) + ", needed is one width");
  return snow::feature_spec(encoding_);
}

bool Features::combine(const Image& disparity, const Image& depth_map, Image& out) noexcept {
  snow::make_features(encoding_, disparity, depth_map, config_.census.width, out);
  return true;
}

}  // namespace vdisp
