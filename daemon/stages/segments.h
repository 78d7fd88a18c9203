// segments.h: stages `segments` and `segment_obstacles`: the paper's first approach (2.3.1), to be compared with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"

namespace vdisp {

/// Disparity and FloorModel (which may be blind) to gray8, the number of the segment, 0 none, those beyond 255 again from 1; and mask8, 255
/// where the segment is an obstacle.
///
/// "Segment the image in different objects and then check the height and the slope of the objects. If the height or the slope are above a
/// threshold, the object is considered as an obstacle." A segment is what hangs together, its neighbouring disparities at most SpeckleDiff
/// apart, flat with flat and steep with steep, and of more than SpeckleSize pixels; height: of an upright
/// strip whose points scatter as much up and down, against max_height, as lowest and highest point are the matcher's mistakes; slope: of
/// its main axis seen from aside, against maxSlope, as the paper prints no number. No floor is asked: pitch is angRot, the model's only
/// where that is auto. Nothing reads it: the paper gave it up, as segments join and fall apart.
class Segments final : public ImageProcessor {
 public:
  explicit Segments(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  static constexpr size_t most = 4096;  // segments; what is beyond is left out
  enum class Kind : uint8_t { none, flat, steep };
  struct Segment {
    int pixels = 0;
    double up = 0, ahead = 0, up2 = 0, ahead2 = 0, mixed = 0;  // sums
    bool obstacle(double max_height, double max_slope) const;
  };
  void measure(const Image& disparity, double pitch) noexcept;
  Kind kind(const Image& disparity, int u, int v) const noexcept;
  void join(const Image& disparity) noexcept;
  void number(int width, int height) noexcept;
  int root(int pixel) noexcept;

  const Config& config_;
  std::vector<float> up_, ahead_;  // m, of each pixel in frame h
  std::vector<Kind> kind_;
  std::vector<int> parent_, size_;  // of a pixel; of a root: its pixels, then -1 - its number
  std::array<Segment, most> segments_;
};

}  // namespace vdisp
