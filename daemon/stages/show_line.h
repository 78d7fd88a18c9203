// show_line.h: displays `show_floor` and `show_limit`: a line drawn into the v-disparity (paper 3.10.1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "daemon/core/processor.h"

namespace vdisp {

/// count16 and line16 of one width to rgb8: votes as brightness on a logarithmic scale, the line in its colour.
class ShowLine final : public BinaryOperator {
 public:
  explicit ShowLine(std::array<uint8_t, 3> colour);
  ImageSpec accept(const ImageSpec& vdisparity, const ImageSpec& line) override;
  bool combine(const Image& vdisparity, const Image& line, Image& out) noexcept override;

 private:
  std::array<uint8_t, 3> colour_;
  std::array<uint8_t, 256> brightness_;  // of a number of votes; more is white
};

}  // namespace vdisp
