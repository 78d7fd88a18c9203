// world.h: closed worlds to drive through: offices, parking garages, open ground with rocks; all from a seed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/sim/people.h"
#include "daemon/sim/scene.h"

namespace vdisp::sim {

/// In the scene's world frame: the robot starts at the origin and looks ahead along z.
struct World {
  std::vector<SceneObject> objects;  ///< walls on all sides among them
  std::vector<SceneObject> panes;    ///< glass: solid, and seen by nobody
  std::vector<Walker> walkers;
  Spot middle;
  double extent = 12;        ///< m: half the side of a square round all of it
  double ceiling = 0;        ///< m over the ground; 0: the sky
  Point to_light{0, -1, 0};  ///< towards the sun, or the lamps
  double ground_brightness = 112;
};

World make_world(const sim_section& parameters);

class Site;
void build_office(Site& site);
void build_garage(Site& site);
void build_rocks(Site& site);

}  // namespace vdisp::sim
