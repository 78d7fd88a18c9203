// plot.h: curves in the unit square, as the paper's figures 11 to 13, as SVG and PNG.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

namespace vdisp::train {

struct Curve {
  std::string name;
  std::vector<std::array<double, 2>> points;  ///< x and y from 0 to 1
};

struct Plot {
  std::string title, x, y;
  std::vector<Curve> curves;  ///< six at most have colours of their own
  bool filled = false;        ///< the area under the first curve, as in figure 11
};

std::string svg_of(const Plot& plot);
std::string png_of(const Plot& plot);

}  // namespace vdisp::train
