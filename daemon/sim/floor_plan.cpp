// floor_plan.cpp: questions to all outlines, the far ones answered by their circles.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/floor_plan.h"

#include <algorithm>

#include "daemon/sim/robot.h"
#include "daemon/sim/scene.h"
#include "daemon/sim/shapes.h"

namespace vdisp::sim {
namespace {

const char* word(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::box: return "box";
    case ObjectKind::post: return "post";
    case ObjectKind::wall: return "wall";
    case ObjectKind::rock: return "rock";
    case ObjectKind::beam: return "beam";
  }
  return "thing";
}

}  // namespace

FloorPlan::FloorPlan(std::span<const SceneObject> objects, std::span<const SceneObject> panes, size_t people, uint32_t seed) {
  for (size_t i = 0; i < objects.size(); ++i) {
    const SceneObject& o = objects[i];
    if (o.bottom < Robot::height && o.height > Robot::climbs) things_.push_back({covered(o, bumps(seed, i)), word(o.kind)});
  }
  for (const SceneObject& o : panes) things_.push_back({covered(o, 0), "glass"});
  first_person_ = things_.size();
  constexpr Spot nowhere{1e6, 1e6};  // until they are placed
  for (size_t i = 0; i < people; ++i) things_.push_back({Footprint::disc(nowhere, girth / 2), "person"});
}

void FloorPlan::place_people(std::span<const Spot> spots) {
  for (size_t i = 0; i < spots.size(); ++i) things_[first_person_ + i].outline = Footprint::disc(spots[i], girth / 2);
}

const FloorPlan::Thing* FloorPlan::met(const Footprint& outline) const {
  const auto found = std::find_if(things_.begin(), things_.end(), [&](const Thing& thing) { return thing.outline.meets(outline); });
  return found == things_.end() ? nullptr : &*found;
}

double FloorPlan::gap(const Footprint& outline, double far) const {
  for (const Thing& thing : things_)
    if (distance(thing.outline.middle(), outline.middle()) < far + thing.outline.radius() + outline.radius())
      far = std::min(far, thing.outline.gap(outline));
  return far;
}

double FloorPlan::gap(const Spot& spot, double far) const {
  for (const Thing& thing : things_)
    if (distance(thing.outline.middle(), spot) < far + thing.outline.radius()) far = std::min(far, thing.outline.gap(spot));
  return far;
}

double FloorPlan::way(const Spot& from, double heading, double half, double far) const {
  const Spot along = towards(heading);
  for (const Thing& thing : things_) far = std::min(far, thing.outline.ahead(from, along, half, far));
  return far;
}

}  // namespace vdisp::sim
