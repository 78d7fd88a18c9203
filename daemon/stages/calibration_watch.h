// calibration_watch.h: stage `row_error`: whether the calibration still holds, by a few good matches of each frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/row_line.h"
#include "ipc/records.h"

namespace vdisp {

/// Rectified left and right view and their disparity to a CalibrationWatch. Needs to run in every frame (Need::always): in each it looks at
/// a dozen places of the image, so that all of it has its turn within a few frames, and judges the points of the last seconds every few
/// frames. An image that is blurred, dark or without texture gives no points, and no verdict.
class CalibrationWatcher final : public ImageProcessor {
 public:
  explicit CalibrationWatcher(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;
  void begin_anew() noexcept override;

 private:
  void look(const Image& left, const Image& right, const Image& disparity) noexcept;
  void look_in(int cell, const Image& left, const Image& right, const Image& disparity) noexcept;
  void judge(const Image& left) noexcept;

  const Config& config_;
  RowPoints points_;
  RowLine line_;
  CalibrationState state_ = CalibrationState::measuring;
  uint64_t drifts_ = 0;
  int cell_ = 0;      // where the last frame stopped
  int unjudged_ = 0;  // points since the last verdict
  std::minstd_rand chance_{1};
};

}  // namespace vdisp
