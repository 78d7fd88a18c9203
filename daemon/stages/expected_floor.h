// expected_floor.h: part of `disparity`: where in the image the floor is expected, before this frame is matched.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "config/config.h"
#include "daemon/kernels/shear.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// The floor as a plane of disparities: d = slope (v - row0) + tilt (u - cx) + cx_offset, px.
struct ExpectedFloor {
  double slope = 0, row0 = 0, tilt = 0, cx = 0, cx_offset = 0;

  /// True disparity d' at the centre column, 0 at the horizon.
  double at_row(int row) const { return slope * (row - row0); }
  kernels::RowDisparity row(int row) const;
  /// First row of an image `width` wide in which some of the floor lies below its horizon.
  int first_row(int width) const;
};

/// From the floor of the last frame, while it agrees with [mounting] as far as that is given; else from [mounting]; else, for a while, from
/// the last floor found.
class FloorExpectation {
 public:
  explicit FloorExpectation(const Config& config) : config_(config) {}
  /// `view` has the geometry of this frame and its sequence; `last` is the floor model of the last one, or null.
  std::optional<ExpectedFloor> expect(const Image& view, const FloorModel* last) noexcept;

  /// As before the first frame.
  void forget() noexcept { last_found_.reset(); }

 private:
  std::optional<ExpectedFloor> from_mounting(const Image& view) const noexcept;

  const Config& config_;
  std::optional<ExpectedFloor> last_found_;
  uint64_t last_sequence_ = 0;
};

}  // namespace vdisp
