// shade.cpp: the loops of shade_loops.h for the instruction sets of x86, and for any processor.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/shade.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

#include "daemon/sim/texture.h"

namespace vdisp::sim {
namespace {

constexpr float haze_brightness = 205, haze_distance = 70, fine_texels_per_m = 320, coarse_texels_per_m = 83;

using Index = int32_t __attribute__((vector_size(32)));
using Words = uint32_t __attribute__((vector_size(32)));
#define ALWAYS [[gnu::always_inline]] inline

namespace plain {
ALWAYS Words gather(const uint32_t* from, Index at) {
  return Words{from[at[0]], from[at[1]], from[at[2]], from[at[3]], from[at[4]], from[at[5]], from[at[6]], from[at[7]]};
}
/// Bytes of `word` weighted by bytes of `x` and added in pairs, these weighted by the halves of `y` and added.
ALWAYS Index weigh(Words word, Index x, Index y) {
  const Index upper = (Index)(word & 255) * (x & 255) + (Index)(word >> 8 & 255) * (x >> 8 & 255);
  const Index lower = (Index)(word >> 16 & 255) * (x >> 16 & 255) + (Index)(word >> 24) * (x >> 24 & 255);
  return upper * (y & 0xffff) + lower * (y >> 16);
}
/// True where one lane is negative, as the lanes of a comparison that holds are.
ALWAYS bool any(Index lanes) { return (lanes[0] | lanes[1] | lanes[2] | lanes[3] | lanes[4] | lanes[5] | lanes[6] | lanes[7]) < 0; }
#include "daemon/sim/shade_loops.h"
}  // namespace plain

#ifdef __x86_64__
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
ALWAYS Words gather(const uint32_t* from, Index at) {
  return (Words)_mm256_i32gather_epi32(reinterpret_cast<const int*>(from), (__m256i)at, 4);
}
ALWAYS Index weigh(Words word, Index x, Index y) {
  return (Index)_mm256_madd_epi16(_mm256_maddubs_epi16((__m256i)word, (__m256i)x), (__m256i)y);
}
ALWAYS bool any(Index lanes) { return _mm256_movemask_ps((__m256)lanes) != 0; }
#include "daemon/sim/shade_loops.h"
}  // namespace avx2
#pragma GCC pop_options
#endif

}  // namespace

Shader plain_shader() { return {plain::aim, plain::colour, plain::expose}; }

Shader choose_shader() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return {avx2::aim, avx2::colour, avx2::expose};
#endif
  return plain_shader();
}

}  // namespace vdisp::sim
