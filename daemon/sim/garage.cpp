// garage.cpp: a parking garage: lanes, bays with cars, pillars.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/objects.h"
#include "daemon/sim/site.h"

namespace vdisp::sim {
namespace {

constexpr double tall = 2.4, bay_width = 2.5, bay_depth = 5;  // m

std::vector<SceneObject> car(Chance& chance, double length, double width) {
  const Finish paint{Surface::stone, chance.between(40, 210), chance.between(0.4, 0.9)}, dark{Surface::stone, chance.between(30, 80), 0.6},
      tyre{Surface::bark, 40, 1};
  std::vector<SceneObject> parts{
      part(ObjectKind::box, 0, 0, width, length, 0.2, 0.78, paint),
      part(ObjectKind::box, 0, chance.between(-0.2, 0.2), width * 0.88, length * 0.5, 0.78, chance.between(1.35, 1.6), dark)};
  for (const double side : {-1.0, 1.0})
    for (const double end : {-1.0, 1.0})
      parts.push_back(part(ObjectKind::box, side * (width / 2 - 0.12), end * length * 0.31, 0.22, 0.62, 0, 0.6, tyre));
  return parts;
}

/// Bays side by side between x0 and x1, their inner ends at z; `side` is where the lane is.
void park(Site& site, double x0, double x1, double z, double side) {
  Chance& chance = site.chance;
  const double share = chance.between(0.35, 0.8);
  int bay = 0;
  for (double x = x0; x + bay_width <= x1; x += bay_width, ++bay) {
    if (bay % 3 == 0) {
      const double width = chance.between(0.4, 0.55);
      site.add(
          part(ObjectKind::box, x, z + side * (bay_depth - 0.4), width, width, 0, tall, {Surface::stone, chance.between(110, 200), 1}));
    }
    if (chance.between(0, 1) > share) continue;
    const double length = chance.between(3.6, 4.6), width = chance.between(1.6, 1.85), in = chance.between(0.25, 0.5);
    const Spot at{x + bay_width / 2 + chance.between(-0.15, 0.15), z + side * (in + length / 2)};
    site.put(car(chance, length, width), at, chance.between(-0.05, 0.05) + (chance.below(2) ? M_PI : 0), width, length, 0.1);
  }
}

}  // namespace

void build_garage(Site& site) {
  Chance& chance = site.chance;
  const bool wide = chance.below(2) != 0;
  const double lane = chance.between(5.2, 6.2);
  // One lane between two rows, or two lanes round a double row.
  const Spot far{wide ? chance.between(19, 24) : chance.between(24, 30), wide ? 4 * bay_depth + 2 * lane : 2 * bay_depth + lane};
  const Finish concrete{Surface::stone, chance.between(110, 180), 1};
  site.enclose(far, tall, concrete);
  site.world.ceiling = tall;
  site.world.to_light = {0.35, -0.90, -0.28};
  park(site, 0.3, far.x - 0.3, 0.1, 1);
  park(site, 0.3, far.x - 0.3, far.z - 0.1, -1);
  if (wide) {
    const double middle = far.z / 2;
    site.wall({4.2, middle}, {far.x - 4.2, middle}, 1.1, concrete, 0.2);
    park(site, 4.2, far.x - 4.2, middle - 0.2, -1);
    park(site, 4.2, far.x - 4.2, middle + 0.2, 1);
  }
  const Spot start{chance.between(4, far.x - 4), bay_depth + lane / 2 + 0.1};
  site.keep_clear(start, 1.5);
  for (int i = 0; i < 8; ++i) {
    const double width = chance.between(0.25, 0.6);
    const Spot at{chance.between(1, far.x - 1), chance.between(1, far.z - 1)};
    const auto kind = chance.below(2) ? ObjectKind::post : ObjectKind::box;
    site.put({part(kind, 0, 0, width, width, 0, chance.between(0.4, 1), {Surface::bark, chance.between(120, 220), 1})}, at,
             chance.between(-1, 1), width, width, 1.2);
  }
  // Screens across half a lane, before a stair's door or a desk.
  for (int i = 0; i < 3; ++i) {
    const double x = site.glazier.between(2, far.x - 4), z = bay_depth + site.glazier.between(0.6, lane - 0.6);
    if (distance({x + 1, z}, start) > 2.5) site.pane({x, z}, {x + 2, z + site.glazier.between(-0.8, 0.8)});
  }
  site.start_at(start, chance.below(2) ? M_PI / 2 : -M_PI / 2);
}

}  // namespace vdisp::sim
