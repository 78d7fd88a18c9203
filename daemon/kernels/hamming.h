// hamming.h: contract: block matching of two census images, with the paper's confidence test.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "daemon/kernels/plane.h"

namespace vdisp::kernels {

/// One search. A pixel's cost at a shift of d px is the bits by which the two codes differ, summed over the window.
struct HammingSearch {
  View8 left, right;     ///< census codes, of one size
  int window = 9;        ///< odd, 3 .. 21
  int disparities = 32;  ///< multiple of 16, 16 .. 256
  int confidence = 0;    ///< the least sum, over all shifts, of cost less best cost: disparities * window^2 * bits a pixel
  int16_t refused = 0;   ///< what is written where it is less
  int16_t outside = 0;   ///< what is written where window or search leave the image

  /// Columns [first, last) have window and whole search inside.
  int first_column() const { return window / 2 + disparities - 1; }
  int last_column() const { return left.width - window / 2; }
};

/// Work space of one band of rows for searches of up to this size.
class HammingScratch {
 public:
  HammingScratch() = default;
  HammingScratch(int width, int disparities) : line_((static_cast<size_t>(width) + 2 * 64 + 63) / 64 * 64) {
    memory_.resize((static_cast<size_t>(disparities) + 20) * line_ / sizeof(Line));
  }
  size_t line() const { return line_; }
  uint8_t* bytes(size_t lines) { return memory_[0].bytes + lines * line_; }

 private:
  struct alignas(64) Line {
    uint8_t bytes[64];
  };
  size_t line_ = 0;
  std::vector<Line> memory_;
};

/// Rows [first, last) of `out`, in 1/16 px: the shift that costs least, of equals the smallest, if what the shifts cost on average is more
/// than that by the confidence (Kueblbeck, Ach, Ernst 2005, 2.3); it is a whole number of px. Other rows are not touched.
using MatchHamming = void(const HammingSearch& search, int first, int last, HammingScratch& scratch, Plane<int16_t> out);

namespace plain {
MatchHamming match_hamming;
}

}  // namespace vdisp::kernels
