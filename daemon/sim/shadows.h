// shadows.h: how the ground is lit, for a scene that does not change: made once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/sim/scene.h"
#include "daemon/sim/shade.h"
#include "daemon/sim/texture.h"
#include "daemon/sim/tracer.h"

namespace vdisp::sim {

/// Shadows, softened, a darker ground beside what stands on it, and patches of dirt. `shadow`: how much darker it is there, 0 to 1.
GroundLight bake(const Scene& scene, const Tracer& tracer, const Textures& textures, double shadow);

}  // namespace vdisp::sim
