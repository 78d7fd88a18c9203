// fused_map.h: stages `fused` and `fused_reason`: what all frames saw, in the odometry frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/core/processor.h"
#include "daemon/stages/fused_grid.h"
#include "daemon/stages/seen_through.h"

namespace vdisp {

/// occupancy, reason, disparity, FloorModel and Memory of one frame to an int8 grid (-1 unknown, 0 to 30 free, 70 to 100 obstacle or
/// drop-off) and a gray8 grid of CellReason, both around the rover, along the odometry's axes, which the header tells.
///
/// Each cell of the grid asks the frame's cell in which its middle lies, so that nothing is resampled twice, and no cell stays empty where
/// the grids are turned against each other; obstacle cells that no middle lies in are added where their own middle lies. Obstacles and
/// drop-offs speak for, free ground (up to free_up_to) against; between them what is likelier an obstacle speaks for, the rest says
/// nothing. What is unknown in the frame says nothing, but where an obstacle is remembered and rays passed through it. Nothing speaks
/// against an obstacle nearer than can be matched, nor against what lies behind such a one.
///
/// Without memory (Memory::state) the cells are those of the frame, along the camera's axes, and the flag `memory` is not set.
class FusedMap final : public ImageProcessor {
 public:
  explicit FusedMap(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override;

 private:
  /// The cells of the grid that may lie in the frame's.
  struct Window {
    int top, bottom, left, right;
  };
  struct Frame {
    const Image &occupancy, &reason;
    Placement placement;
  };
  void tell_frame(const Frame& frame, std::span<Image* const> out) const noexcept;
  Window window(const Frame& frame) const noexcept;
  void fuse(const Frame& frame, SeenThrough& rays, std::span<Image* const> out) noexcept;
  void take(const Frame& frame, const Window& window, SeenThrough& rays, std::span<Image* const> out) noexcept;
  void weigh(int row, int column, int8_t seen, CellReason why, const OnGround& in_h, const SeenThrough& rays,
             std::span<Image* const> out) noexcept;
  void add_missed(const Frame& frame, std::span<Image* const> out) noexcept;
  void add_obstacle(int row, int column, int8_t seen, CellReason why, std::span<Image* const> out) noexcept;

  const Config& config_;
  FusedGrid grid_;
  int rows_ = 0, columns_ = 0;  // of the frame's grid
  std::vector<uint8_t> asked_;  // of the frame's cells: some middle lies in them
  uint32_t forgotten_ = 0;
  int64_t last_ns_ = 0;
};

}  // namespace vdisp
