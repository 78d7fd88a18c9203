// ways.h: part of `decision` and `cross_check`: which detectors a tree has, by the images that a stage is given.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "daemon/core/processor.h"
#include "daemon/stages/classify.h"
#include "daemon/stages/map_driver.h"

namespace vdisp {

/// Of the first detector a grid, int8 with its reasons or count16; of the second SnowScores; or all of them, in this order.
class Ways {
 public:
  explicit Ways(const Config& config) : map_(config) {}
  /// Reserves memory. Throws FormatError for anything else.
  void prepare(std::span<const ImageSpec> in);
  bool has_map() const { return maps_ > 0; }
  bool has_snow() const { return snow_; }
  MapWay map(std::span<const Image* const> in) noexcept { return map_.look(*in[0], maps_ == 2 ? in[1] : nullptr); }
  Way snow(std::span<const Image* const> in) const noexcept { return way_of(*in[maps_]->row<SnowScores>(0)); }

 private:
  MapDriver map_;
  size_t maps_ = 0;  // images of the first detector
  bool snow_ = false;
};

}  // namespace vdisp
