// disparities.h: disparity images that hurt: rejected pixels, values beside and at the ends of the search, one value everywhere.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/search.h"
#include "tests/kernels/check.h"

namespace vdisp::kernels {

enum class Scene { rejected, one_value, slanted, ends, noise, mixed };
inline constexpr Scene all_scenes[] = {Scene::rejected, Scene::one_value, Scene::slanted, Scene::ends, Scene::noise, Scene::mixed};

inline const std::vector<Search> searches = {{0, 1, 768},        {0, 1, 256},   {-512, 1, 768},    {160, 160, 512},
                                             {4096, 4100, 4096}, {0, 256, 256}, {-2048, -2047, 16}};

inline void fill(Picture<int16_t>& picture, Scene scene, const Search& search, uint32_t seed) {
  std::minstd_rand random(seed + 1);
  const Plane<int16_t> p = picture.plane();
  const int ends[] = {search.least - 1, search.least, search.first, search.first - 1, search.end() - 1,
                      search.end(),     -32768,       32767,        -32000,           -32007};
  for (int y = 0; y < p.height; ++y) {
    for (int x = 0; x < p.width; ++x) {
      const int noise = static_cast<int>(random() >> 4), inside = search.first + noise % search.columns;
      int value = 0;
      switch (scene) {
        case Scene::rejected: value = -32001 - noise % 7; break;
        case Scene::one_value: value = search.end() - 1; break;
        case Scene::slanted: value = search.first + (x / 3 + 5 * y) % search.columns; break;
        case Scene::ends: value = ends[noise % 10]; break;
        case Scene::noise: value = noise % 65536 - 32768; break;
        case Scene::mixed: value = noise % 3 ? inside : -32001; break;
      }
      p.row(y)[x] = static_cast<int16_t>(value);
    }
  }
}

}  // namespace vdisp::kernels
