// floor_plan.h: what stands in a robot's way, seen from above: what it runs into, and how far the way is free.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "daemon/sim/footprint.h"

namespace vdisp::sim {

struct SceneObject;

class FloorPlan {
 public:
  struct Thing {
    Footprint outline;
    const char* what;
  };
  static constexpr double girth = 0.64;  ///< m, of people: as far as their legs swing

  /// What a robot neither rolls over nor drives under, as a scene of this seed draws it; panes of glass are as solid as the rest.
  FloorPlan(std::span<const SceneObject> objects, std::span<const SceneObject> panes, size_t people, uint32_t seed);
  /// Where they are now. As many as were announced.
  void place_people(std::span<const Spot> spots);

  const std::vector<Thing>& things() const { return things_; }
  size_t first_person() const { return first_person_; }
  /// What an outline overlaps; null: nothing.
  const Thing* met(const Footprint& outline) const;
  /// m to the nearest thing, at most `far`.
  double gap(const Footprint& outline, double far) const;
  double gap(const Spot& spot, double far) const;
  /// m from a spot along a heading that a strip, `half` m to each side, is free; at most `far`.
  double way(const Spot& from, double heading, double half, double far) const;

 private:
  std::vector<Thing> things_;  ///< people last
  size_t first_person_;
};

}  // namespace vdisp::sim
