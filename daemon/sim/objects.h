// objects.h: what stands about in the scenes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/sim/chance.h"
#include "daemon/sim/scene.h"

namespace vdisp::sim {

/// With the surface that its kind has.
SceneObject make(ObjectKind kind, double x, double z, double width, double depth, double height, double yaw, double brightness);
/// A crate, post or rock of an obstacle's size, at the origin.
SceneObject random_object(Chance& chance);
/// One that a rover climbs: 0.05 to 0.15 m.
SceneObject small_object(Chance& chance);

}  // namespace vdisp::sim
