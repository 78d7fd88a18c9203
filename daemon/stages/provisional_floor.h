// provisional_floor.h: part of `disparity`: the floor that matches show which no filter has seen yet.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/stages/floor.h"
#include "daemon/stages/vdisparity.h"
#include "ipc/outlet.h"

namespace vdisp {

/// The stages `vdisparity` and `floor` once more, on images of their own.
class ProvisionalFloor {
 public:
  ProvisionalFloor(Machine& machine, const Config& config) : vdisparity_(machine, config), floor_(machine, config) {}
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& disparity);
  /// The floor of `disparity`, its header complete; null if there is none.
  const FloorModel* find(const Image& disparity) noexcept;

 private:
  VDisparity vdisparity_;
  Floor floor_;
  std::unique_ptr<BufferOutlet> votes_, line_, model_;
};

}  // namespace vdisp
