// map_changes.h: stage `map_changes`: which cells of the occupancy are other than in the last frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/core/processor.h"
#include "ipc/records.h"

namespace vdisp {

/// int8 grid to a MapChanges record: what dynamic planners in the manner of E* are fed with. Needs to run in every frame (Need::always):
/// it compares with a copy of its own of the last grid. Of a blind grid the driver makes a blind record and does not run the stage; the
/// hole that this leaves in the sequence is how the next grid is known to come after blindness.
class MapComparison final : public ImageProcessor {
 public:
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override;

 private:
  WholeGrid comparable(const Image& grid) const noexcept;
  void compare(const Image& grid, MapChanges& changes) noexcept;

  std::vector<int8_t> last_;  // row by row, no padding
  bool compares_ = false;     // last_ is a grid that was there
  uint64_t generation_ = 0;
  uint64_t sequence_ = 0, epoch_ = 0;  // of the last grid
  GridGeometry geometry_{};
};

}  // namespace vdisp
