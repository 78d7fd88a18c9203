// objects.cpp: crates, posts and rocks by chance.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/objects.h"

namespace vdisp::sim {

SceneObject make(ObjectKind kind, double x, double z, double width, double depth, double height, double yaw, double brightness) {
  constexpr Surface surfaces[] = {Surface::gravel, Surface::planks, Surface::bark, Surface::bricks, Surface::stone, Surface::planks};
  SceneObject object;
  object.kind = kind;
  object.x = x;
  object.z = z;
  object.width = width;
  object.depth = depth;
  object.height = height;
  object.yaw = yaw;
  object.surface = surfaces[static_cast<int>(kind)];
  object.brightness = brightness;
  return object;
}

SceneObject random_object(Chance& chance) {
  const double yaw = chance.between(-0.8, 0.8);
  switch (chance.below(5)) {
    case 0:
    case 1:
      return make(ObjectKind::box, 0, 0, chance.between(0.3, 0.8), chance.between(0.3, 0.6), chance.between(0.3, 0.9), yaw,
                  chance.between(110, 170));
    case 2: {
      const double width = chance.between(0.12, 0.3);
      return make(ObjectKind::post, 0, 0, width, width, chance.between(0.7, 1.6), yaw, chance.between(120, 190));
    }
    default: {
      const double width = chance.between(0.35, 0.9);
      return make(ObjectKind::rock, 0, 0, width, width * chance.between(0.7, 1), chance.between(0.3, 0.6), yaw, chance.between(120, 165));
    }
  }
}

SceneObject small_object(Chance& chance) {
  const double height = chance.between(0.05, 0.15), yaw = chance.between(-0.8, 0.8);
  if (chance.below(2) == 0)
    return make(ObjectKind::box, 0, 0, chance.between(0.12, 0.4), chance.between(0.1, 0.3), height, yaw, chance.between(110, 170));
  const double width = chance.between(1.4, 2.2) * height;
  return make(ObjectKind::rock, 0, 0, width, width, height, yaw, chance.between(120, 165));
}

}  // namespace vdisp::sim
