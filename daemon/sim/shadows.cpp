// shadows.cpp: a ray from each cell of the ground towards the light.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/shadows.h"

#include <algorithm>
#include <vector>

namespace vdisp::sim {

GroundLight bake(const Scene& scene, const Tracer& tracer, const Textures& textures, double shadow) {
  constexpr int side = GroundLight::side;
  GroundLight light;
  const double half = scene.extent(), cell = 2 * half / side;
  light.x0 = static_cast<float>(scene.middle_x() - half);
  light.z0 = static_cast<float>(scene.middle_z() - half);
  light.cells_per_m = static_cast<float>(1 / cell);
  std::vector<uint8_t> lit(static_cast<size_t>(side) * side), packed(lit.size());
  std::vector<Point> row(side);
  // Triangles lie up to 3 mm beside the ground that they stand for.
  const double above = scene.terrain().meshed() ? 0.01 : 0.002;
  // Lamps hang below their ceiling.
  const double below = scene.ceiling() - 0.05;
  const float reach = below > 0 ? static_cast<float>(below / -scene.to_light().y) : far_away;
  for (int j = 0; j < side; ++j) {
    const double z = scene.middle_z() - half + (j + 0.5) * cell;
    for (int i = 0; i < side; ++i) {
      const double x = scene.middle_x() - half + (i + 0.5) * cell;
      row[i] = {x, scene.ground(x, z) - above, z};
    }
    tracer.light(row.data(), side, scene.to_light(), reach, &lit[static_cast<size_t>(j) * side]);
  }
  const uint32_t* dirt = textures.texels.data() + static_cast<int>(Surface::stone) * Textures::words + Textures::level_start(3);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      int sum = 0;
      for (int b = -1; b <= 1; ++b) {
        for (int a = -1; a <= 1; ++a)
          sum += lit[static_cast<size_t>(std::clamp(j + b, 0, side - 1)) * side + std::clamp(i + a, 0, side - 1)];
      }
      const double patch = static_cast<double>(dirt[(j / 8 & 63) * 64 + (i / 8 & 63)] & 255) / 255;
      packed[static_cast<size_t>(j) * side + i] = static_cast<uint8_t>(255 * (1 - shadow + shadow * sum / 9) * (0.88 + 0.12 * patch));
    }
  }
  light.packed = pack(packed, side, false);
  return light;
}

}  // namespace vdisp::sim
