// shapes.h: what an obstacle looks like to the ray tracer, and what space it takes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "daemon/sim/footprint.h"
#include "daemon/sim/ground.h"
#include "daemon/sim/scene.h"

namespace vdisp::sim {

/// The surface of an object, of which `seed` gives a rock its bumps. `ground` is the world's y where it stands.
Mesh shape(const SceneObject& object, double ground, uint32_t seed);
/// That seed of a scene's index-th object.
uint32_t bumps(uint32_t scene_seed, size_t index);
/// What its surface covers of the ground from where wheels do not climb to the robot's top (of what they do: all of it): solid is what is
/// drawn.
Footprint covered(const SceneObject& object, uint32_t seed);

using Corners = std::array<Point, 8>;  ///< neighbours differ in one bit of their index
/// The corners of boxes that hold the object: one, or several for what is so long that one would be a poor fit on the screen.
std::vector<Corners> boxes_around(const SceneObject& object, double ground);

}  // namespace vdisp::sim
