// shade_loops.h: the loops over a tile, eight pixels at a time. Included by shade.cpp alone, once for each instruction set: it is
// compiled for the one that is on at that line, and expects `gather`, `weigh` and `any` to be defined there.
// SPDX-License-Identifier: Apache-2.0

using F = float __attribute__((vector_size(32)));
using I = int32_t __attribute__((vector_size(32)));
using U = uint32_t __attribute__((vector_size(32)));
using Bytes = uint8_t __attribute__((vector_size(8)));
constexpr int lanes = 8;

ALWAYS F load(const float* from) {
  F value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
ALWAYS void store(float* to, F value) { __builtin_memcpy(to, &value, sizeof value); }
ALWAYS F all(float value) { return F{} + value; }
ALWAYS F lesser(F a, F b) { return a < b ? a : b; }
ALWAYS F greater(F a, F b) { return a > b ? a : b; }
ALWAYS F within(F value, float least, float most) { return lesser(greater(value, all(least)), all(most)); }
ALWAYS F size_of(F value) { return (F)((I)value & 0x7fffffff); }
ALWAYS F as_float(I value) { return __builtin_convertvector(value, F); }
/// Towards zero.
ALWAYS I cut(F value) { return __builtin_convertvector(value, I); }
ALWAYS F gather(const float* from, I at) { return (F)gather(reinterpret_cast<const uint32_t*>(from), at); }

/// 1 / sqrt(value) to 1e-6: a guess by the exponent, and three steps of Newton.
ALWAYS F inverse_root(F value) {
  F guess = (F)(0x5f375a86 - ((I)value >> 1));
  for (int step = 0; step < 3; ++step) guess = guess * (1.5f - 0.5f * value * guess * guess);
  return guess;
}

/// log2 to 0.01, which is plenty to choose a resolution by.
ALWAYS F rough_log2(F value) {
  const I bits = (I)value;
  const F mantissa = (F)((bits & 0x007fffff) | 0x3f800000);
  return as_float((bits >> 23) - 127) + (mantissa - 1.0f) * (1.6731f - 0.3365f * mantissa);
}

/// Between the four texels of each word, in 1/127 of the way to the next: 0..255 * 127 * 127.
ALWAYS F blend(U word, I part_x, I part_y) {
  const I pair = (part_x ^ 127) | part_x << 8;
  return as_float(weigh(word, pair | pair << 16, (part_y ^ 127) | part_y << 16));
}

/// Places in 1/128 texel of a level, and where its words lie.
struct Place {
  I u, v, level, last, start;
};
ALWAYS Place place_in(I surface, F u, F v, I level) {
  const F scale = (F)((127 + 7 - level) << 23);
  // Textures::level_start; the division by 3 is exact, so it is a product.
  const U all_words = U{} + (1u << (2 * Textures::log_size + 2));
  const I start = (I)((all_words - (all_words >> (U)(2 * level))) * 0xaaaaaaabu);
  return {cut(u * scale - 64.0f), cut(v * scale - 64.0f), level, (Textures::size >> level) - 1, surface + start};
}
/// The same place in the level of half the resolution.
ALWAYS Place halved(const Place& at) {
  return {(at.u - 64) >> 1, (at.v - 64) >> 1, at.level + 1, at.last >> 1, at.start + ((at.last + 1) << (Textures::log_size - at.level))};
}
ALWAYS F look_up(const uint32_t* texels, const Place& at) {
  const I index = at.start + (((at.v >> 7 & at.last) << (Textures::log_size - at.level)) | (at.u >> 7 & at.last));
  return blend(gather(texels, index), at.u & 127, at.v & 127);
}

/// -1..1, from the two resolutions next to `level`.
ALWAYS F sample(const uint32_t* texels, I surface, F u, F v, F level) {
  level = within(level, 0, static_cast<float>(Textures::levels) - 1.001f);
  const I sharper = cut(level);
  const Place at = place_in(surface, u, v, sharper);
  const F a = look_up(texels, at), b = look_up(texels, halved(at));
  return (a + (b - a) * (level - as_float(sharper))) * (1 / (127.5f * 127 * 127)) - 1.0f;
}

/// The same from the nearest resolution alone, for what is not looked at closely.
ALWAYS F sample_roughly(const uint32_t* texels, I surface, F u, F v, F level) {
  const I near = cut(within(level + 0.5f, 0, static_cast<float>(Textures::levels) - 1));
  return look_up(texels, place_in(surface, u, v, near)) * (1 / (127.5f * 127 * 127)) - 1.0f;
}

ALWAYS F hazy(F gray, F distance) {
  const F depth = distance * (1 / haze_distance), squared = depth * depth;
  return gray + (haze_brightness - gray) * (squared / (1.0f + squared));
}

/// x and z: the place; u and v: where that is on the texture.
ALWAYS F ground_gray(const Look& look, F x, F z, F u_fine, F v_fine, F t, F grazing) {
  // Along the view the ground is foreshortened by 1 / grazing: a compromise between blur across and shimmer along.
  const F width = t * (look.pixel * fine_texels_per_m), squared = width * width;
  const F level = 0.25f * rough_log2(squared * squared / grazing);
  const F fine = sample(look.texels, I{}, u_fine * fine_texels_per_m, v_fine * fine_texels_per_m, level);
  // Turned, so that the repetition of the one falls between that of the other.
  const F u = 0.83f * u_fine + 0.55f * v_fine, v = 0.83f * v_fine - 0.55f * u_fine;
  const F coarse = sample_roughly(look.texels, I{}, u * coarse_texels_per_m, v * coarse_texels_per_m, level - 1.95f);
  const GroundLight& light = *look.light;
  const float most = static_cast<float>(GroundLight::side) - 1.01f;
  const I lu = cut(within((x - light.x0) * light.cells_per_m, 0, most) * 128.0f);
  const I lv = cut(within((z - light.z0) * light.cells_per_m, 0, most) * 128.0f);
  const F lit =
      blend(gather(light.packed.data(), (lv >> 7) * GroundLight::side + (lu >> 7)), lu & 127, lv & 127) * (1 / (255.0f * 127 * 127));
  const F shade = 1.0f - (look.contrast < 1 ? look.contrast : 1) * (1.0f - lit);
  return look.ground * shade * (1.0f + look.contrast * (0.75f * fine + look.coarse * coarse));
}

/// Ground that has a mesh: steep parts carry their texture upright, and turn towards the sun or from it.
ALWAYS F meshed_gray(const Look& look, const Batch& batch, int i, F t) {
  const F dx = load(batch.dx + i), dy = load(batch.dy + i), dz = load(batch.dz + i);
  F nx = load(batch.nx + i), ny = load(batch.ny + i), nz = load(batch.nz + i);
  const F inverse = inverse_root(greater(nx * nx + ny * ny + nz * nz, all(1e-20f))), up = ny > 0.0f ? -inverse : inverse;
  nx *= up;
  ny *= up;
  nz *= up;
  const F x = look.x + t * dx, y = look.y + t * dy, z = look.z + t * dz;
  const F aside = inverse_root(greater(nx * nx + nz * nz, all(1e-12f)));
  const I steep = ny > -0.7f;
  const F u = steep ? (x * nz - z * nx) * aside : x, v = steep ? y : z;
  const F grazing = within(size_of(nx * dx + ny * dy + nz * dz), 0.01f, 1);
  const F sun = greater(nx * look.sun_x + ny * look.sun_y + nz * look.sun_z, F{});
  return ground_gray(look, x, z, u, v, t, grazing) * (0.5f + 0.5f * sun) * (1.0f / (0.5f + 0.5f * size_of(all(look.sun_y))));
}

ALWAYS F sky_gray(const Look& look, F dx, F dy, F dz) {
  const F up = greater(-dy, all(0.02f)), across = 1.0f / up;
  const I surface = I{} + static_cast<int32_t>(Surface::stone) * Textures::words;
  const F cloud = sample_roughly(look.texels, surface, dx * across * 60.0f, dz * across * 60.0f, rough_log2(across * across) + 3.0f);
  return haze_brightness + 22.0f * lesser(up, all(0.8f)) +
         26.0f * (look.contrast < 1 ? look.contrast : 1) * cloud * lesser(up * 4.0f, all(1.0f));
}

void aim(const Look& look, const float* x, const float* y, Batch& batch) {
  const float* m = look.axes;
  for (int i = 0; i < Batch::size; i += lanes) {
    const F rx = load(x + i), ry = load(y + i);
    const F dx = m[0] * rx + m[1] * ry + m[2], dy = m[3] * rx + m[4] * ry + m[5], dz = m[6] * rx + m[7] * ry + m[8];
    const F level = -look.y / dy, at = look.z + level * dz;
    const F slope = -(look.y + look.rise * (look.z - look.slope_start)) / (dy + look.rise * dz), slope_at = look.z + slope * dz;
    const F near = (level > 0.0f) & (at <= look.slope_start) ? level : all(far_away);
    const F ahead = (slope > 0.0f) & (slope_at > look.slope_start) ? slope : all(far_away);
    store(batch.dx + i, dx);
    store(batch.dy + i, dy);
    store(batch.dz + i, dz);
    store(batch.t + i, lesser(lesser(near, ahead), all(far_away)));
    const I none = I{} - 1;
    __builtin_memcpy(batch.object + i, &none, sizeof none);
  }
}

void draw_background(const Look& look, Batch& batch) {
  for (int i = 0; i < Batch::size; i += lanes) {
    const F dx = load(batch.dx + i), dy = load(batch.dy + i), dz = load(batch.dz + i), t = load(batch.t + i);
    I hit;
    __builtin_memcpy(&hit, batch.object + i, sizeof hit);
    const I ground = (t < far_away) & (hit < 0), sky = t >= far_away;
    F gray = F{};
    if (any(sky)) gray = sky_gray(look, dx, dy, dz);
    if (any(ground)) {
      const F reach = ground ? t : all(1);
      const F grazing = within(size_of(dy + look.rise * dz), 0.01f, 1);
      const F x = look.x + reach * dx, z = look.z + reach * dz;
      const F bare = look.meshed ? meshed_gray(look, batch, i, reach) : ground_gray(look, x, z, x, z, reach, grazing);
      gray = ground ? hazy(bare, reach) : gray;
    }
    store(batch.gray + i, gray);
  }
}

ALWAYS F object_gray(const Look& look, const Batch& batch, int i, I object) {
  const ObjectTable& table = *look.objects;
  const F dx = load(batch.dx + i), dy = load(batch.dy + i), dz = load(batch.dz + i), t = lesser(load(batch.t + i), all(1000));
  const F cosine = gather(table.cos_yaw.data(), object), sine = gather(table.sin_yaw.data(), object);
  const F px = look.x + t * dx - gather(table.x.data(), object), pz = look.z + t * dz - gather(table.z.data(), object);
  const F height = gather(table.y.data(), object) - look.y - t * dy;
  const F along = px * cosine + pz * sine, aside = pz * cosine - px * sine;
  const F nx = load(batch.nx + i), ny = load(batch.ny + i), nz = load(batch.nz + i);
  const F inverse = inverse_root(greater(nx * nx + ny * ny + nz * nz, all(1e-20f)));
  const F facing = (nx * dx + ny * dy + nz * dz) * inverse, sign = facing > 0.0f ? -inverse : inverse;
  const F n_along = size_of(nx * cosine + nz * sine), n_aside = size_of(nz * cosine - nx * sine);
  const I top = size_of(ny) > greater(n_along, n_aside), side = n_along > n_aside;
  // Joints of the side begin half a plank from those of the front.
  const F u = top ? along : side ? aside + 0.37f : along, v = top ? aside + 0.61f : height;
  const F density = gather(table.texels_per_m.data(), object), shift = gather(table.shift.data(), object);
  const F width = t * look.pixel * density, level = 0.5f * rough_log2(width * width / greater(size_of(facing), all(0.05f)));
  const I surface = (I)gather(reinterpret_cast<const uint32_t*>(table.texture.data()), object);
  const F value = sample(look.texels, surface, (u + shift) * density, (v + shift) * density, level);
  const F sun = greater((nx * look.sun_x + ny * look.sun_y + nz * look.sun_z) * sign, F{});
  const F light = (0.55f + 0.55f * sun) * (0.70f + 0.30f * within(height * 6.0f, 0, 1));
  return hazy(gather(table.brightness.data(), object) * light * (1.0f + gather(table.contrast.data(), object) * value), t);
}

void draw_objects(const Look& look, Batch& batch) {
  for (int i = 0; i < Batch::size; i += lanes) {
    I hit;
    __builtin_memcpy(&hit, batch.object + i, sizeof hit);
    if (any(~hit)) store(batch.gray + i, hit >= 0 ? object_gray(look, batch, i, hit & ~(hit >> 31)) : load(batch.gray + i));
  }
}

void colour(const Look& look, bool objects, Batch& batch) {
  draw_background(look, batch);
  if (objects) draw_objects(look, batch);
}

void expose(const Look& look, const Batch& batch, uint32_t place, uint32_t row_step, uint8_t* out) {
  // Four bytes of a hash, added, are Gaussian enough: deviation 147.8, +-3.4 of them at most.
  const float strength = look.noise / 147.8f;
  const U column = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int i = 0; i < Batch::size; i += lanes) {
    const auto y = static_cast<uint32_t>(i / Rays::tile_width), x = static_cast<uint32_t>(i % Rays::tile_width);
    U h = (place + y * row_step + x + column) ^ look.noise_seed;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    h ^= h >> 16;
    const I sum = (I)((h & 255) + (h >> 8 & 255) + (h >> 16 & 255) + (h >> 24));
    const I value = cut(within(load(batch.gray + i) * look.gain + as_float(sum - 510) * strength + 0.5f, 0, 255));
    const Bytes bytes = __builtin_convertvector(value, Bytes);
    __builtin_memcpy(out + i, &bytes, sizeof bytes);
  }
}
