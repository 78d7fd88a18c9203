// rectify.h: stages `left` and `right`: one raw view to its rectified view, and from here on images know their metres.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/geometry/calibration.h"
#include "daemon/stages/machine.h"

namespace vdisp {

enum class Side { left = 0, right = 1 };

/// gray8 to gray8. Without calibration, or with one of rectified images, the view is passed on as it is. Where [image source] bayer
/// says that the view is a colour mosaic it is turned into grey first.
class Rectify final : public ImageFilter {
 public:
  /// Throws FormatError (in accept) where calibration, configuration and images are of different sizes.
  Rectify(Side side, std::optional<Calibration> calibration, Machine& machine, const Config& config);
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Side side_;
  std::optional<Calibration> calibration_;
  Machine& machine_;
  const Config& config_;
  std::optional<kernels::Bayer> bayer_;
  CameraGeometry geometry_{};
  kernels::RectifyTable table_;
  std::vector<uint8_t> grey_;  // the raw view without its mosaic, as large as the image
};

}  // namespace vdisp
