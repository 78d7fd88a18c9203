// semi_global_matcher.h: part of `disparity`: semi-global matching of our own, for floors and objects with little texture.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Two gray8 views to disparities with reasons, all filters but that of speckles (Hirschmueller, PAMI 2008, on census codes).
///
/// What the parameters of SVS (paper table 3) become:
///   ndisp, minDisparity  the disparities searched
///   unique               percent by which the best match must be better than any more than 1 px away. Sums of paths differ less than
///                        sums of windows: a quarter of it does the same
///   thresh, corrsize     as in block_matcher.h, but a quarter of it: a path needs little. thresh also lowers what a path may cost, up to
///                        25 of it: what is noise in one view matches nothing well in the other
///
/// With 3 paths the image is done in groups of rows that stay in the cache; with more all of it is kept, 2 bytes for each pixel and
/// disparity.
class SemiGlobalMatcher {
 public:
  SemiGlobalMatcher(Machine& machine, const Config& config);
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& spec);
  void match(const Image& left, const Image& right, Image& out) noexcept;

 private:
  /// Census codes of one view, padded as the kernels ask.
  struct Codes {
    void resize(const ImageSpec& spec);
    kernels::Plane<uint8_t> low, high;
    std::vector<uint8_t> memory;
  };
  kernels::SemiGlobal search_in(const Image& left) const;
  void encode(const Image& view, Codes& codes) noexcept;
  void add_paths(const kernels::SemiGlobal& search, int first_row, int last_row, bool up) noexcept;
  void choose(const kernels::SemiGlobal& search, int first_row, int last_row, Image& out) noexcept;

  Machine& machine_;
  const Config& config_;
  const int paths_;
  Codes left_, right_;
  kernels::SemiGlobalVolume volume_;
  std::vector<std::vector<uint16_t>> candidates_;  // a row for each thread
  std::vector<std::vector<uint16_t>> textures_;
  kernels::Plane<uint8_t> gradient_;
  std::vector<uint8_t> gradient_memory_;
  size_t row_ = 0;  // elements of a row of candidates
};

}  // namespace vdisp
