// rocks.cpp: open ground with rocks, stones and trees, inside a fence.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/objects.h"
#include "daemon/sim/site.h"

namespace vdisp::sim {

void build_rocks(Site& site) {
  Chance& chance = site.chance;
  const double side = chance.between(20, 26);
  const Spot far{side, side}, start{side / 2 + chance.between(-4, 4), side / 2 + chance.between(-4, 4)};
  site.enclose(far, 1.3, {chance.below(2) ? Surface::planks : Surface::stone, chance.between(110, 160), 1});
  const double sun = chance.between(0, 2 * M_PI), high = chance.between(0.5, 1.1);
  site.world.to_light = {std::cos(high) * std::cos(sun), -std::sin(high), std::cos(high) * std::sin(sun)};
  site.keep_clear(start, 1.6);
  const auto anywhere = [&] { return Spot{chance.between(0.6, side - 0.6), chance.between(0.6, side - 0.6)}; };
  const int count = 45 + chance.below(40);
  for (int i = 0; i < count; ++i) {
    const bool large = chance.below(5) == 0;
    const double width = large ? chance.between(1.2, 2.4) : chance.between(0.45, 1.1), depth = width * chance.between(0.7, 1);
    const double height = large ? chance.between(0.8, 1.6) : chance.between(0.3, 0.9);
    site.put({part(ObjectKind::rock, 0, 0, width, depth, 0, height, {Surface::stone, chance.between(90, 175), 1})}, anywhere(),
             chance.between(-M_PI, M_PI), width, depth, Site::passage);
  }
  for (int i = 0; i < 14; ++i) {
    const double width = chance.between(0.16, 0.5);
    site.put({part(ObjectKind::post, 0, 0, width, width, 0, chance.between(1.6, 3), {Surface::bark, chance.between(80, 150), 1})},
             anywhere(), chance.between(-M_PI, M_PI), width, width, Site::passage);
  }
  // Pebbles that wheels roll over.
  for (int i = 0; i < 40; ++i) {
    const double width = chance.between(0.06, 0.14);
    site.put({part(ObjectKind::rock, 0, 0, width, width, 0, chance.between(0.02, 0.05), {Surface::stone, chance.between(90, 190), 1})},
             anywhere(), 0, width, width, 0.05);
  }
  for (int i = 0; i < 6; ++i) {
    const Spot a{site.glazier.between(2, side - 4), site.glazier.between(2, side - 4)};
    const double turn = site.glazier.between(0, M_PI);
    if (distance(a, start) > 4) site.pane(a, {a.x + 2 * std::cos(turn), a.z + 2 * std::sin(turn)});
  }
  site.start_at(start, chance.between(-M_PI, M_PI));
}

}  // namespace vdisp::sim
