// expected_floor.h: part of `disparity`: where in the image the floor is expected, before this frame is matched.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/kernels/shear.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// The floor as a plane of disparities: d = slope (v - row0) + tilt (u - cx) + cx_offset, px; or, with `bent`, as rows of their own: on a
/// ramp the ground recedes from row to row by less than on the plane before it.
struct ExpectedFloor {
  double slope = 0, row0 = 0, tilt = 0, cx = 0, cx_offset = 0;
  std::span<const float> bent = {};  ///< true disparity by row, at the centre column; below 0: no floor is expected there

  /// True disparity d' at the centre column, 0 at the horizon.
  double at_row(int row) const { return bent.empty() ? slope * (row - row0) : static_cast<double>(bent[static_cast<size_t>(row)]); }
  kernels::RowDisparity row(int row) const;
  /// First row of an image `width` wide in which some of the floor lies below its horizon.
  int first_row(int width) const;
};

/// From the floor of the last frame, while it agrees with [mounting] as far as that is given, or may be a ramp; else from [mounting]; else,
/// for a while, from the last floor found.
class FloorExpectation {
 public:
  explicit FloorExpectation(const Config& config) : config_(config) {}
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& spec) { bent_.assign(spec.height, 0.0f); }
  /// `view` has the geometry of this frame and its sequence; `last` is the floor model of the last one, or null.
  std::optional<ExpectedFloor> expect(const Image& view, const FloorModel* last) noexcept;

  /// Whether what expect() gave last may be far off: no floor was found. While there are none, with [mounting], once in 30 frames.
  bool doubtful(const Image& view) noexcept;

  /// As before the first frame.
  void forget() noexcept {
    last_found_.reset();
    doubted_.reset();
    pitched_ = {};
  }

 private:
  std::optional<ExpectedFloor> from_mounting(const Image& view) const noexcept;
  bool contradicts(const FloorModel& last) const noexcept;
  double turn(const Image& view, const FloorModel* last) noexcept;
  void bend(const Image& view, const FloorModel& last, double pitch, ExpectedFloor& floor) noexcept;

  /// Of the frame before: its time, and the pitch of the floor of the one before that; NaN: there was none, or it was not found.
  struct Pitched {
    int64_t frame_ns = 0, floor_ns = 0;
    double pitch = NAN;
  };

  const Config& config_;
  std::vector<float> bent_;
  Pitched pitched_;
  std::optional<ExpectedFloor> last_found_;
  uint64_t last_sequence_ = 0;
  std::optional<uint64_t> doubted_;  // sequence
};

}  // namespace vdisp
