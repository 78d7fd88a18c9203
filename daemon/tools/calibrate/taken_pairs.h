// taken_pairs.h: pairs in memory as a source of the daemon's stages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "daemon/sources/source.h"

namespace vdisp::calibrate {

/// Pairs of gray8, all of one size, one after the other and then the end; with the calibration that they are to be rectified by.
class TakenPairs final : public StereoSource {
 public:
  TakenPairs(std::vector<std::array<cv::Mat, 2>> pairs, std::optional<Calibration> calibration)
      : pairs_(std::move(pairs)), calibration_(std::move(calibration)) {}

  std::vector<ImageSpec> open() override {
    const cv::Mat& first = pairs_.at(0)[0];
    const ImageSpec spec{Pixel::gray8, 0, static_cast<uint16_t>(first.cols), static_cast<uint16_t>(first.rows)};
    return {spec, spec};
  }
  Outcome grab(std::span<Image* const> out) noexcept override {
    if (next_ == pairs_.size()) return Outcome::end;
    for (size_t side : {0u, 1u}) {
      const cv::Mat& view = pairs_[next_][side];
      out[side]->timestamp_ns = static_cast<int64_t>(next_) * apart_ns;
      for (int y = 0; y < view.rows; ++y) std::copy_n(view.ptr(y), view.cols, out[side]->row<uint8_t>(y));
    }
    ++next_;
    return Outcome::valid;
  }
  std::optional<Calibration> calibration() const override { return calibration_; }
  int64_t period_ns() const override { return 0; }

 private:
  static constexpr int64_t apart_ns = 100'000'000;
  std::vector<std::array<cv::Mat, 2>> pairs_;
  std::optional<Calibration> calibration_;
  size_t next_ = 0;
};

}  // namespace vdisp::calibrate
