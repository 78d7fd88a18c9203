// debayer.h: contracts: the grey picture behind a colour mosaic, of which a camera sees one colour a pixel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// Colours of the first two pixels of the first row, then of the second.
enum class Bayer { rggb, bggr, grbg, gbrg };

/// Rows [first, last) of the luma of a mosaic. The two colours a pixel lacks are the means of its two or four nearest of that colour
/// (bilinear interpolation; columns and rows beyond the image are mirrored at the border pixel, 1 stands for -1), and luma is
/// 0.299 red + 0.587 green + 0.114 blue: with the colours in 1/128 and their weights in 1/32768,
///   m(c, w) = (c w + 16384) >> 15, out = (m(red, 9798) + m(green, 19235) + m(blue, 3735) + 64) >> 7
/// A flat colour thus gives the same luma at all its pixels, within 0.52 levels of the real one. `out` has the size of `in` and is not
/// the same memory; other rows are not touched.
using Debayer = void(View8 in, Bayer pattern, int first, int last, Plane<uint8_t> out);

/// What the pixels of a row have: column 0 is red or blue, not green; the weights of red or blue, the row's own, and of the other.
struct BayerRow {
  BayerRow(Bayer pattern, int y)
      : colour_first((pattern == Bayer::rggb || pattern == Bayer::bggr) == (y % 2 == 0)),
        own((pattern == Bayer::rggb || pattern == Bayer::grbg) == (y % 2 == 0) ? red : blue),
        other(own == red ? blue : red) {}
  static constexpr int16_t red = 9798, green = 19235, blue = 3735;
  bool colour_first;
  int16_t own, other;
};

namespace plain {
Debayer debayer;
/// One pixel.
uint8_t debayered(View8 in, const BayerRow& row, int x, int y);
}  // namespace plain

}  // namespace vdisp::kernels
