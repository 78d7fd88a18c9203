// shade.h: the arithmetic of one tile of the picture: rays, ground, surfaces, camera noise. Plain loops, compiled twice.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/sim/lens.h"

namespace vdisp::sim {

inline constexpr float far_away = 1e5f;  ///< m; a ray that goes farther sees the sky

/// One tile on its way from rays to grey levels, world frame.
struct alignas(64) Batch {
  static constexpr int size = Rays::tile_pixels;
  float dx[size], dy[size], dz[size];  ///< direction, 1 m along the view
  float t[size];                       ///< m along the view
  float nx[size], ny[size], nz[size];  ///< normal of the object hit, any length
  int32_t object[size];                ///< index of the object hit, -1: none
  float gray[size];
};

/// The objects as the loops read them, one array for each property.
struct ObjectTable {
  std::vector<float> x, y, z, cos_yaw, sin_yaw, brightness, contrast, shift, texels_per_m;
  std::vector<int32_t> texture;  ///< first word of its surface
};

/// Sunlight, dirt and shadow on the ground, on a square from above; 255 = full light.
struct GroundLight {
  static constexpr int side = 512;
  float x0 = 0, z0 = 0, cells_per_m = 1;
  std::vector<uint32_t> packed;
};

/// All that a tile's grey levels depend on besides its rays.
struct Look {
  float axes[9], x, y, z;  ///< camera in the world
  float rise, slope_start;
  float pixel;                ///< width of a pixel 1 m away
  float sun_x, sun_y, sun_z;  ///< towards the sun
  float contrast;             ///< of all textures
  float gain, noise;
  uint32_t noise_seed;
  const uint32_t* texels;
  const ObjectTable* objects;
  const GroundLight* light;
  bool meshed = false;   ///< the ground is one of the tracer's shapes; rise and slope_start say nothing
  float covered = -1;    ///< grey level of what is before the lens; negative: nothing is
  float ground = 112;    ///< grey level of the ground in full light
  float coarse = 0.55f;  ///< weight of the ground's second texture, which hides that the first repeats
};

struct Shader {
  /// Rays to directions, and how far the ground is along each; no object.
  void (*aim)(const Look&, const float* x, const float* y, Batch&);
  /// Grey levels without camera errors.
  void (*colour)(const Look&, bool objects, Batch&);
  /// What the sensor makes of them; `place` is unique for each pixel of the tile's rows, a row apart by `row_step`.
  void (*expose)(const Look&, const Batch&, uint32_t place, uint32_t row_step, uint8_t* out);
};
/// The fastest this processor has. All give the same bytes.
Shader choose_shader();
Shader plain_shader();

}  // namespace vdisp::sim
