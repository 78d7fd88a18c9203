// shade.cpp: the loops over a tile. Written to be vectorised: no branch, no call, one array for each value.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/shade.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "daemon/sim/chance.h"
#include "daemon/sim/texture.h"

namespace vdisp::sim {
namespace {

#define ALWAYS [[gnu::always_inline]] inline
constexpr int count = Batch::size;
constexpr float ground_brightness = 112, haze_brightness = 205, fine_texels_per_m = 320, coarse_texels_per_m = 83;

ALWAYS int32_t whole(float value) {
  const int32_t cut = static_cast<int32_t>(value);
  return cut - (static_cast<float>(cut) > value);
}

/// log2 to 0.01, which is plenty to choose a resolution by.
ALWAYS float rough_log2(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const float m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u);
  return static_cast<float>(static_cast<int32_t>(bits >> 23) - 127) + (m - 1) * (1.3465553f - 0.3465553f * m + 0.0f);
}

/// Between four texels of one word.
ALWAYS float blend(uint32_t word, float fx, float fy) {
  const float a = static_cast<float>(static_cast<int32_t>(word & 255)), b = static_cast<float>(static_cast<int32_t>(word >> 8 & 255));
  const float c = static_cast<float>(static_cast<int32_t>(word >> 16 & 255)), d = static_cast<float>(static_cast<int32_t>(word >> 24));
  const float upper = a + (b - a) * fx, lower = c + (d - c) * fx;
  return upper + (lower - upper) * fy;
}

ALWAYS float sample_level(const uint32_t* texels, int32_t surface, float u, float v, int32_t level) {
  const float scale = std::bit_cast<float>((127 - level) << 23);
  const float us = u * scale - 0.5f, vs = v * scale - 0.5f;
  const int32_t iu = whole(us), iv = whole(vs), side = Textures::size >> level;
  // Textures::level_start; the division by 3 is exact, so it is a product.
  const uint32_t all = 1u << (2 * Textures::log_size + 2);
  const uint32_t start = (all - (all >> (2 * level))) * 0xaaaaaaabu;
  const int32_t index = surface + static_cast<int32_t>(start) + (((iv & (side - 1)) << (Textures::log_size - level)) | (iu & (side - 1)));
  return blend(texels[index], us - static_cast<float>(iu), vs - static_cast<float>(iv));
}

/// -1..1, from the two resolutions next to `level`.
ALWAYS float sample(const uint32_t* texels, int32_t surface, float u, float v, float level) {
  level = std::min(std::max(level, 0.0f), static_cast<float>(Textures::levels) - 1.001f);
  const int32_t sharper = static_cast<int32_t>(level);
  const float part = level - static_cast<float>(sharper);
  const float a = sample_level(texels, surface, u, v, sharper), b = sample_level(texels, surface, u, v, sharper + 1);
  return (a + (b - a) * part) * (1 / 127.5f) - 1;
}

ALWAYS void aim_body(const Look& look, const float* x, const float* y, Batch& batch) {
  const float* m = look.axes;
  for (int i = 0; i < count; ++i) {
    const float dx = m[0] * x[i] + m[1] * y[i] + m[2], dy = m[3] * x[i] + m[4] * y[i] + m[5], dz = m[6] * x[i] + m[7] * y[i] + m[8];
    const float level = -look.y / dy, at = look.z + level * dz;
    const float slope = -(look.y + look.rise * (look.z - look.slope_start)) / (dy + look.rise * dz), slope_at = look.z + slope * dz;
    const float near = level > 0 && at <= look.slope_start ? level : far_away;
    const float ahead = slope > 0 && slope_at > look.slope_start ? slope : far_away;
    batch.dx[i] = dx;
    batch.dy[i] = dy;
    batch.dz[i] = dz;
    batch.t[i] = std::min(std::min(near, ahead), far_away);
    batch.object[i] = -1;
  }
}

ALWAYS float ground_gray(const Look& look, float x, float z, float t, float grazing) {
  // Along the view the ground is foreshortened by 1 / grazing: a compromise between blur across and shimmer along.
  const float width = t * look.pixel;
  const float level = rough_log2(width * fine_texels_per_m) - 0.5f * rough_log2(grazing);
  const float fine = sample(look.texels, 0, x * fine_texels_per_m, z * fine_texels_per_m, level);
  // Turned, so that the repetition of the one falls between that of the other.
  const float u = 0.83f * x + 0.55f * z, v = 0.83f * z - 0.55f * x;
  const float coarse = sample(look.texels, 0, u * coarse_texels_per_m, v * coarse_texels_per_m, level - 1.95f);
  const GroundLight& light = *look.light;
  const float most = static_cast<float>(GroundLight::side) - 1.01f;
  const float lu = std::min(std::max((x - light.x0) * light.cells_per_m, 0.0f), most);
  const float lv = std::min(std::max((z - light.z0) * light.cells_per_m, 0.0f), most);
  const int32_t iu = static_cast<int32_t>(lu), iv = static_cast<int32_t>(lv);
  const float lit = blend(light.packed.data()[iv * GroundLight::side + iu], lu - static_cast<float>(iu), lv - static_cast<float>(iv)) * (1 / 255.0f);
  const float shade = 1 - std::min(look.contrast, 1.0f) * (1 - lit);
  return ground_brightness * shade * (1 + look.contrast * (0.65f * fine + 0.6f * coarse));
}

ALWAYS float sky_gray(const Look& look, float dx, float dy, float dz) {
  const float up = std::max(-dy, 0.02f), across = 1 / up;
  const float cloud = sample(look.texels, static_cast<int32_t>(Surface::stone) * Textures::words, dx * across * 60, dz * across * 60,
                             rough_log2(across * across) + 3);
  return haze_brightness + 22 * std::min(up, 0.8f) + 26 * std::min(look.contrast, 1.0f) * cloud * std::min(up * 4, 1.0f);
}

ALWAYS void background_body(const Look& look, Batch& batch) {
  for (int i = 0; i < count; ++i) {
    const float dx = batch.dx[i], dy = batch.dy[i], dz = batch.dz[i], t = batch.t[i];
    const bool ground = t < far_away;
    const float reach = ground ? t : 1.0f;
    const float grazing = std::max(std::abs(dy + look.rise * dz), 0.01f);
    const float surface = ground_gray(look, look.x + reach * dx, look.z + reach * dz, reach, std::min(grazing, 1.0f));
    const float depth = reach * (1 / 70.0f), haze = depth * depth / (1 + depth * depth);
    const float sky = sky_gray(look, dx, dy, dz);
    batch.gray[i] = ground ? surface + (haze_brightness - surface) * haze : sky;
  }
}

ALWAYS void objects_body(const Look& look, Batch& batch) {
  const ObjectTable& table = *look.objects;
  const float *ox = table.x.data(), *oy = table.y.data(), *oz = table.z.data(), *cosine = table.cos_yaw.data(), *sine = table.sin_yaw.data();
  const float *brightness = table.brightness.data(), *contrast = table.contrast.data(), *shift = table.shift.data(), *density = table.texels_per_m.data();
  const int32_t* texture = table.texture.data();
  for (int i = 0; i < count; ++i) {
    const int32_t hit = batch.object[i], o = std::max(hit, 0);
    const float dx = batch.dx[i], dy = batch.dy[i], dz = batch.dz[i], t = std::min(batch.t[i], 1000.0f);
    const float px = look.x + t * dx - ox[o], height = oy[o] - look.y - t * dy, pz = look.z + t * dz - oz[o];
    const float along = px * cosine[o] + pz * sine[o], aside = pz * cosine[o] - px * sine[o];
    const float nx = batch.nx[i], ny = batch.ny[i], nz = batch.nz[i];
    const float inverse = 1 / std::sqrt(std::max(nx * nx + ny * ny + nz * nz, 1e-20f));
    const float facing = (nx * dx + ny * dy + nz * dz) * inverse, sign = facing > 0 ? -inverse : inverse;
    const float n_along = std::abs(nx * cosine[o] + nz * sine[o]), n_aside = std::abs(nz * cosine[o] - nx * sine[o]);
    const bool top = std::abs(ny) > std::max(n_along, n_aside), side = n_along > n_aside;
    const float u = top ? along : side ? aside + 0.37f : along, v = top ? aside + 0.61f : height;
    const float level = rough_log2(t * look.pixel * density[o]) - 0.5f * rough_log2(std::max(std::abs(facing), 0.05f));
    const float value = sample(look.texels, texture[o], (u + shift[o]) * density[o], (v + shift[o]) * density[o], level);
    const float sun = std::max((nx * look.sun_x + ny * look.sun_y + nz * look.sun_z) * sign, 0.0f);
    const float light = (0.58f + 0.50f * sun) * (0.70f + 0.30f * std::min(std::max(height, 0.0f) * 6, 1.0f));
    const float surface = brightness[o] * light * (1 + contrast[o] * value);
    const float depth = t * (1 / 70.0f), haze = depth * depth / (1 + depth * depth);
    batch.gray[i] = hit >= 0 ? surface + (haze_brightness - surface) * haze : batch.gray[i];
  }
}

ALWAYS void expose_body(const Look& look, const Batch& batch, uint32_t place, uint32_t row_step, uint8_t* out) {
  // Four bytes of a hash, added, are Gaussian enough: deviation 147.8, +-3.4 of them at most.
  const float strength = look.noise / 147.8f;
  for (int y = 0; y < Rays::tile_height; ++y) {
    for (int x = 0; x < Rays::tile_width; ++x) {
      const int i = y * Rays::tile_width + x;
      const uint32_t h = scramble((place + static_cast<uint32_t>(y) * row_step + static_cast<uint32_t>(x)) * 0x9e3779b9u ^ look.noise_seed);
      const int32_t sum = static_cast<int32_t>((h & 255) + (h >> 8 & 255) + (h >> 16 & 255) + (h >> 24));
      const float value = batch.gray[i] * look.gain + static_cast<float>(sum - 510) * strength + 0.5f;
      out[i] = static_cast<uint8_t>(static_cast<int32_t>(std::min(std::max(value, 0.0f), 255.0f)));
    }
  }
}

void aim_plain(const Look& look, const float* x, const float* y, Batch& batch) { aim_body(look, x, y, batch); }
void colour_plain(const Look& look, bool objects, Batch& batch) {
  background_body(look, batch);
  if (objects) objects_body(look, batch);
}
void expose_plain(const Look& look, const Batch& batch, uint32_t place, uint32_t row_step, uint8_t* out) {
  expose_body(look, batch, place, row_step, out);
}

#ifdef __x86_64__
#define AVX2 [[gnu::target("avx2")]]
AVX2 void aim_avx2(const Look& look, const float* x, const float* y, Batch& batch) { aim_body(look, x, y, batch); }
AVX2 void background_avx2(const Look& look, Batch& batch) { background_body(look, batch); }
AVX2 void objects_avx2(const Look& look, Batch& batch) { objects_body(look, batch); }
void colour_avx2(const Look& look, bool objects, Batch& batch) {
  background_avx2(look, batch);
  if (objects) objects_avx2(look, batch);
}
AVX2 void expose_avx2(const Look& look, const Batch& batch, uint32_t place, uint32_t row_step, uint8_t* out) {
  expose_body(look, batch, place, row_step, out);
}
#endif

}  // namespace

Shader plain_shader() { return {aim_plain, colour_plain, expose_plain}; }

Shader choose_shader() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return {aim_avx2, colour_avx2, expose_avx2};
#endif
  return plain_shader();
}

}  // namespace vdisp::sim
