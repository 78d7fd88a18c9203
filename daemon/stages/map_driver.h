// map_driver.h: part of `decision`: what the map says of the way ahead: a corridor as wide as the rover, and what stands in it first.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/stages/steering.h"
#include "ipc/image.h"

namespace vdisp {

struct MapWay : Way {
  double corridor_m = 0;  ///< to the first obstacle or unknown ground in the corridor, at most [decide] far; from the rover's origin
};

/// Reacts to one grid, and plans nothing: int8 (occupancy, fused) with the CellReason of each cell, or count16 (map), which knows nothing
/// of unknown ground. The corridor lies straight ahead in the rover frame, [decide] width and a margin on each side wide.
///
/// The way is free where no obstacle stands in the corridor nearer than [decide] near, and at most a third of the cells there that
/// can be looked at is unknown: unknown ground near the rover is not free. What lies below the picture or too near for the matcher can
/// not be looked at; it was when the rover came, and a grid that remembers tells it. Where the nearest cell in view lies beyond near, the
/// next 0.3 m decide instead: what stands or may stand there would be out of view before it is near.
///
/// Cells in which something may stand (between free_up_to and occupied_from; of a grid that remembers those that are unknown because of an
/// obstacle or a drop-off) lower the clearness as obstacles do, and so the speed; up to near, along the corridor, they are obstacles. That
/// may be what a single frame is wrong about: standing and turning for a frame is less than coming nearer for one.
///
/// Evades to the side on which, turning, the first free corridor is found; of equals where the corridors reach farther, else left.
class MapDriver {
 public:
  explicit MapDriver(const Config& config) : config_(config) {}
  /// Reserves memory for grids of this size.
  void prepare(const ImageSpec& grid);
  /// `reason` is null for a count16.
  MapWay look(const Image& grid, const Image* reason) noexcept;

 private:
  struct Cell {
    float ahead, left;  // m, rover frame
    bool suspected, unknown;
  };
  void collect(const Image& grid, const Image* reason) noexcept;
  double first_obstacle(double turned, double suspected_to) const noexcept;
  double nearest() const noexcept;
  double first_unknown(double zone) const noexcept;
  bool evade_left(double end) const noexcept;
  double half_width() const noexcept { return config_.decide.width / 2 + config_.decide.margin; }

  const Config& config_;
  std::vector<Cell> obstacles_, ground_;  // up to far; what is suspected is among the obstacles; of the ground what lies in the corridor
};

}  // namespace vdisp
