// site.cpp: puts walls and things on the ground, people on their ways, and the robot at its start.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/site.h"

#include <algorithm>

#include "daemon/sim/floor_plan.h"
#include "daemon/sim/objects.h"
#include "daemon/sim/reach.h"
#include "daemon/sim/shapes.h"

namespace vdisp::sim {
namespace {

/// `by` is subtracted, then turned by -heading.
void carry(Spot& spot, const Spot& by, double heading) {
  const double c = std::cos(heading), s = std::sin(heading), x = spot.x - by.x, z = spot.z - by.z;
  spot = {c * x + s * z, c * z - s * x};
}
void carry(SceneObject& o, const Spot& by, double heading) {
  Spot spot{o.x, o.z};
  carry(spot, by, heading);
  o.x = spot.x;
  o.z = spot.z;
  o.yaw -= heading;
}

/// People walk between places far apart, and begin far from the robot.
void invite(World& world, Chance& chance, int people, uint32_t seed) {
  const FloorPlan plan(world.objects, world.panes, 0, seed);
  const Reach reach(plan, {}, world.middle, world.extent, 0.4);
  const std::vector<Spot>& places = reach.places();
  if (places.size() < 100) return;
  for (int attempt = 0; attempt < 40 * people && static_cast<int>(world.walkers.size()) < people; ++attempt) {
    const auto from = static_cast<size_t>(chance.below(static_cast<int>(places.size()))),
               to = static_cast<size_t>(chance.below(static_cast<int>(places.size())));
    if (distance(places[from], places[to]) < 6 || distance(places[from], {}) < 4) continue;
    world.walkers.push_back({reach.way(from, to), chance.between(0.5, 1.1), 0, chance.between(50, 170)});
  }
}

}  // namespace

SceneObject part(ObjectKind kind, double x, double z, double width, double depth, double bottom, double height, const Finish& finish) {
  SceneObject o = make(kind, x, z, width, depth, height, 0, finish.brightness);
  o.bottom = bottom;
  o.surface = finish.surface;
  o.contrast = finish.contrast;
  return o;
}

void Site::add(const SceneObject& object) {
  outlines_.push_back(covered(object, bumps(seed_, world.objects.size())));
  world.objects.push_back(object);
}

void Site::wall(const Spot& a, const Spot& b, double height, const Finish& finish, double width) {
  SceneObject o = part(ObjectKind::wall, (a.x + b.x) / 2, (a.z + b.z) / 2, distance(a, b), width, 0, height, finish);
  o.yaw = std::atan2(b.z - a.z, b.x - a.x);
  add(o);
}

void Site::enclose(const Spot& far, double height, const Finish& finish) {
  // Each goes on behind the next one's corner.
  constexpr double more = wall_width / 2;
  wall({-more, 0}, {far.x + more, 0}, height, finish);
  wall({far.x, -more}, {far.x, far.z + more}, height, finish);
  wall({far.x + more, far.z}, {-more, far.z}, height, finish);
  wall({0, far.z + more}, {0, -more}, height, finish);
  world.middle = {far.x / 2, far.z / 2};
  world.extent = std::max(far.x, far.z) / 2 + 0.5;
}

void Site::pane(const Spot& a, const Spot& b) {
  SceneObject o = make(ObjectKind::wall, (a.x + b.x) / 2, (a.z + b.z) / 2, distance(a, b), 0.02, 2, 0, 0);
  o.yaw = std::atan2(b.z - a.z, b.x - a.x);
  world.panes.push_back(o);
}

bool Site::room(const Footprint& outline, double gap, double touching) const {
  const auto far = [&](const Footprint& other) {
    const double least = distance(other.middle(), outline.middle()) - other.radius() - outline.radius();
    if (least >= gap) return true;
    const double found = other.gap(outline);
    return found >= gap || (found > 0 && found <= touching);
  };
  return std::all_of(clear_.begin(), clear_.end(), [&](const Clear& c) { return outline.gap(c.spot) >= c.radius; }) &&
         std::all_of(outlines_.begin(), outlines_.end(), far);
}

bool Site::put(const std::vector<SceneObject>& parts, const Spot& at, double yaw, double width, double depth, double gap, double touching) {
  const Footprint whole(at, width, depth, yaw);
  for (const Spot& corner : whole)
    if (std::abs(corner.x - world.middle.x) > world.extent || std::abs(corner.z - world.middle.z) > world.extent) return false;
  if (!room(whole, gap, touching)) return false;
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (SceneObject o : parts) {
    o = SceneObject(o);
    const double x = o.x, z = o.z;
    o.x = at.x + c * x - s * z;
    o.z = at.z + s * x + c * z;
    o.yaw += yaw;
    add(o);
  }
  return true;
}

void Site::start_at(const Spot& spot, double heading) {
  for (SceneObject& o : world.objects) carry(o, spot, heading);
  for (SceneObject& o : world.panes) carry(o, spot, heading);
  carry(world.middle, spot, heading);
  const double turned = std::abs(std::sin(heading)) + std::abs(std::cos(heading));
  world.extent *= turned;
}

World make_world(const sim_section& parameters) {
  Site site(static_cast<uint64_t>(parameters.seed));
  const bool office = parameters.scene == "office", garage = parameters.scene == "garage";
  site.world.ground_brightness = site.chance.between(80, 150);
  office ? build_office(site) : garage ? build_garage(site) : build_rocks(site);
  World& world = site.world;
  invite(world, site.chance, office ? 4 : garage ? 2 : 1, static_cast<uint32_t>(parameters.seed));
  if (!parameters.glass) world.panes.clear();
  if (world.ceiling > 0) {
    const Finish plaster{Surface::stone, 190, 0.5};
    world.objects.push_back(part(ObjectKind::beam, world.middle.x, world.middle.z, 2 * world.extent, 2 * world.extent, world.ceiling,
                                 world.ceiling + 0.2, plaster));
  }
  return std::move(world);
}

}  // namespace vdisp::sim
