// speckle.h: contracts: regions of a disparity image that are too small to be believed are refused.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// A region is a set of pixels that have a disparity, joined by neighbours (left, right, above, below) that differ by at most
/// `max_difference`. One of at most `max_size` pixels is refused. The unit is that of the pixels.
struct SpeckleRule {
  int16_t least;       ///< the least value that is a disparity: whatever is below was rejected before, and is not touched
  int16_t refused;     ///< what the pixels of a refused region become
  int max_difference;  ///< 0 .. 32768 + least: 768 where least is -32000
  int max_size;        ///< pixels
};

/// Work space for one image of at most width x height pixels, whatever it shows; contents are the kernels' own. A run is a stretch of
/// joined pixels in one row; each has an index, rising along rows and bands, and `parent` makes trees of them: a region is a tree.
struct SpeckleScratch {
  /// width <= 65535, and width + 64 times height below 2^31.
  SpeckleScratch(int width, int height);

  struct Row {
    int32_t first, last;  ///< its runs, [first, last)
    bool apart;           ///< first row of a band: not yet joined to the row above
  };
  /// Index of the first run of a band, by the band's first row: bands need not know of each other. 64: kernels write whole vectors.
  int32_t first_run(int row) const { return row * (width + 64); }

  /// 8 * words bit masks for who works on a band, by the band's first row.
  uint64_t* masks(int row) const { return bits.get() + static_cast<ptrdiff_t>(row) * 8 * words; }

  int width, height, words;  ///< words of 64 pixels for a row, and one more
  std::unique_ptr<Row[]> rows;
  std::unique_ptr<int32_t[]> parent, area;  ///< by run; area of the region counts at the root
  std::unique_ptr<uint16_t[]> begin, end;   ///< by run; columns [begin, end)
  std::unique_ptr<uint64_t[]> bits;         ///< 8 * words a row
  std::unique_ptr<uint16_t[]> crossings;    ///< width + 64 a row: where the row at work touches other regions
};

/// Step 1: finds the regions within the band of rows [first, last). Bands of one image do not depend on each other: one thread each, any
/// cut of the image into bands, in any order.
using SpeckleLabel = void(Plane<const int16_t> disparity, const SpeckleRule& rule, int first, int last, SpeckleScratch& scratch);
/// Step 2, when every band has its labels: joins the regions that go on from band to band. One thread.
using SpeckleJoin = void(Plane<const int16_t> disparity, const SpeckleRule& rule, SpeckleScratch& scratch);
/// Step 3: writes `refused` over the refused regions' pixels in rows [first, last), any rows. The result is the same for any bands, and
/// what cv::filterSpeckles makes of it if one value stands for all rejected pixels.
using SpeckleRefuse = void(const SpeckleRule& rule, int first, int last, SpeckleScratch& scratch, Plane<int16_t> disparity);

namespace plain {
SpeckleLabel speckle_label;
SpeckleJoin speckle_join;
SpeckleRefuse speckle_refuse;
}  // namespace plain

}  // namespace vdisp::kernels
