// matched_views.h: part of `disparity`: what the block matcher compares instead of brightness: gradients, or census codes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "config/config.h"
#include "daemon/stages/expected_floor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Both views, and the right one sheared by the floor expected, as the kernels ask: codes of one or two planes, those of the right view
/// mirrored. `prefilter` and `census` say which codes.
class MatchedViews {
 public:
  MatchedViews(Machine& machine, const Config& config);
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& spec);
  void take(const Image& left, const Image& right) noexcept;
  /// Rows from `first_row` on of the view in which the floor expected stands still.
  void take_sheared(const Image& right, const ExpectedFloor& floor, int first_row) noexcept;

  /// Writes planes and kind of cost.
  void put_plain(kernels::BlockSearch& search) const { put(search, right_); }
  void put_sheared(kernels::BlockSearch& search) const { put(search, sheared_); }
  /// The left view's x-Sobel plus `gradient_cap`, by which texture is measured whatever is matched.
  kernels::View8 gradient() const { return (code_ == Code::sobel ? left_ : gradient_).one; }

  static constexpr int gradient_cap = 31;  ///< as in OpenCV's StereoBM: contrast above it counts as this much
  static constexpr int least_band = 32;    ///< rows: joining bands has its price too

 private:
  enum class Code { sobel, log, census3x3, census5x5 };
  /// The codes of one view.
  struct Codes {
    void resize(int width, int height, int margin, bool two);
    kernels::Plane<uint8_t> one, two;  // the second of census5x5 alone
    std::vector<uint8_t> memory;
  };
  int rows_above() const;
  void encode(kernels::View8 view, int first, int last, Codes& codes) noexcept;
  void mirror(int first, int last, Codes& codes) noexcept;
  void put(kernels::BlockSearch& search, const Codes& right) const;

  Machine& machine_;
  const Code code_;
  Codes left_, right_, sheared_;
  Codes moved_, unmirrored_, gradient_;  // on the way there
};

}  // namespace vdisp
