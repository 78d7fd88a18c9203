// provisional_floor.h: part of `disparity`: the floor that matches show which no filter has seen yet.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/stages/floor.h"
#include "daemon/stages/plane_floor.h"
#include "daemon/stages/vdisparity.h"
#include "ipc/outlet.h"

namespace vdisp {

/// The stages `vdisparity` and `floor` once more, on images of their own, in the form that [Floor] model asks for.
class ProvisionalFloor {
 public:
  ProvisionalFloor(Machine& machine, const Config& config)
      : vdisparity_(machine, config), floor_(machine, config), plane_(machine, config), line_only_(config.floor.model == "line") {}
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& disparity);
  /// The line of `disparity`, its header complete; null if there is none.
  const FloorModel* find(const Image& disparity) noexcept;
  /// The same, or the plane with its profile: as the tree would find it.
  const FloorModel* find(const Image& disparity, const Image& left) noexcept;

 private:
  VDisparity vdisparity_;
  Floor floor_;
  PlaneFloor plane_;
  const bool line_only_;
  std::unique_ptr<BufferOutlet> votes_, line_, model_, no_imu_;
};

}  // namespace vdisp
