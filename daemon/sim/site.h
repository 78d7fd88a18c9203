// site.h: where a world is built: walls, panes, and things that keep their distance from each other.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/sim/chance.h"
#include "daemon/sim/world.h"

namespace vdisp::sim {

/// What a wall is made of.
struct Finish {
  Surface surface = Surface::stone;
  double brightness = 150, contrast = 1;
};

class Site {
 public:
  static constexpr double wall_width = 0.14;  ///< m
  static constexpr double passage = 0.9;      ///< m between things, so that a robot comes through or sees that it does not

  explicit Site(uint64_t seed) : chance(seed * 2 + 0x0ff1ce), glazier(seed * 2 + 0x91a55), seed_(static_cast<uint32_t>(seed)) {}

  Chance chance;
  Chance glazier;  ///< for panes, which are always built, and taken out again where no glass is wanted: all else stays as it is
  World world;

  void wall(const Spot& a, const Spot& b, double height, const Finish& finish, double width = wall_width);
  /// Four walls round (0, 0) to `far`.
  void enclose(const Spot& far, double height, const Finish& finish);
  void pane(const Spot& a, const Spot& b);
  void add(const SceneObject& object);
  /// A thing of several parts, given relative to its middle (x across, z along its yaw), is put there if its outline has `gap` m to all
  /// that stands and to the places kept clear. What it stands against (`touching` m to it at most) does not count.
  bool put(const std::vector<SceneObject>& parts, const Spot& at, double yaw, double width, double depth, double gap, double touching = 0);
  void keep_clear(const Spot& spot, double radius) { clear_.push_back({spot, radius}); }
  bool room(const Footprint& outline, double gap, double touching = 0) const;
  /// Makes the spot the origin, and the heading the way ahead. Everything must stand.
  void start_at(const Spot& spot, double heading);

 private:
  struct Clear {
    Spot spot;
    double radius;
  };
  std::vector<Clear> clear_;
  uint32_t seed_;
  std::vector<Footprint> outlines_;  ///< of the world's objects
};

/// A part of a thing: a box or post at (x, z) from its middle.
SceneObject part(ObjectKind kind, double x, double z, double width, double depth, double bottom, double height, const Finish& finish);

}  // namespace vdisp::sim
