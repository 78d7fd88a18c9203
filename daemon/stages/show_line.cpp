// show_line.cpp: for the eye only: a picture of what the floor search saw.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/show_line.h"

#include <algorithm>
#include <cmath>

namespace vdisp {

ShowLine::ShowLine(std::array<uint8_t, 3> colour) : colour_(colour) {
  for (size_t votes = 0; votes < brightness_.size(); ++votes)
    brightness_[votes] = static_cast<uint8_t>(std::lround(255 * std::log2(1.0 + static_cast<double>(votes)) / 8));
}

ImageSpec ShowLine::accept(const ImageSpec& vdisparity, const ImageSpec& line) {
  require(vdisparity, Pixel::count16, "the v-disparity");
  require(line, Pixel::line16, "the line");
  if (line.width != vdisparity.width)
    throw FormatError("the v-disparity has " + std::to_string(vdisparity.width) + " columns, the line " + std::to_string(line.width) +
                      ", needed is one width");
  return {Pixel::rgb8, 0, vdisparity.width, vdisparity.height};
}

bool ShowLine::combine(const Image& vdisparity, const Image& line, Image& out) noexcept {
  for (int v = 0; v < out.spec.height; ++v) {
    const int16_t* votes = vdisparity.row<int16_t>(v);
    uint8_t* pixel = out.row<uint8_t>(v);
    for (int column = 0; column < out.spec.width; ++column, pixel += 3)
      pixel[0] = pixel[1] = pixel[2] = brightness_[static_cast<size_t>(std::clamp<int>(votes[column], 0, 255))];
  }
  const int16_t* rows = line.row<int16_t>(0);
  for (int column = 0; column < out.spec.width; ++column) {
    // Two rows thick, so that it is still seen when the picture is made smaller.
    for (int row = rows[column]; row < rows[column] + 2; ++row) {
      if (rows[column] == line_none || row < 0 || row >= out.spec.height) continue;
      std::copy(colour_.begin(), colour_.end(), out.row<uint8_t>(row) + 3 * column);
    }
  }
  return true;
}

}  // namespace vdisp
