// speckle_pictures.h: pictures of disparities that hurt a speckle filter, and the filter run in bands.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/kernels/check.h"

namespace vdisp::kernels {

inline constexpr int16_t least = -32000, refused = -32004;
inline constexpr int none = -32001;

using Pattern = std::function<int(int x, int y)>;

inline bool on_spiral(int x, int y, int width, int height) {
  const int ring = std::min(std::min(x, y), std::min(width - 1 - x, height - 1 - y));
  // Rings with a gap each are one arm where every second ring has its gap moved into the next.
  return ring % 2 == 0 ? !(x == ring && y == ring + 1) : x == ring && y == ring + 1;
}

/// Pictures of disparities that hurt: by name, for a picture of the size.
inline std::vector<std::pair<std::string, Pattern>> patterns(int width, int height) {
  const auto noise = [](int x, int y) {
    uint32_t h = static_cast<uint32_t>(x) * 2654435761u ^ static_cast<uint32_t>(y) * 2246822519u;
    h = (h ^ h >> 15) * 2246822519u;
    return static_cast<int>(h >> 8 & 0xFFFF);
  };
  return {
      {"all rejected", [](int x, int y) { return none - (x + y) % 7; }},
      {"one region", [](int, int) { return 300; }},
      {"every pixel a region", [](int x, int y) { return (x + y) % 2 ? 0 : 5000; }},
      {"valid and rejected by turns", [](int x, int y) { return (x + y) % 2 ? 20 : none; }},
      {"just joined", [](int x, int y) { return 16 * x - 16 * y; }},
      {"just not joined", [](int x, int y) { return 17 * x + 17 * y; }},
      {"rows", [](int, int y) { return y % 2 ? 100 : none; }},
      {"columns", [](int x, int) { return x % 2 ? 100 : none; }},
      {"U shapes: joined in the last row", [=](int x, int y) { return x % 2 == 0 || y == height - 1 ? 64 : none; }},
      {"U shapes: joined in every tenth row", [](int x, int y) { return x % 2 == 0 || y % 10 == 9 ? 64 + x / 12 : none; }},
      {"comb with a back on top", [](int x, int y) { return x % 2 == 0 || y == 0 ? 64 : -100; }},
      {"nested Us", [=](int x, int y) { return std::max(std::abs(2 * x - width), 2 * y) % 4 < 2 ? 64 : none; }},
      {"nested caps", [=](int x, int y) { return std::max(std::abs(2 * x - width), 2 * (height - y)) % 4 < 2 ? 64 : 900; }},
      {"spiral", [=](int x, int y) { return on_spiral(x, y, width, height) ? 64 : none; }},
      {"extremes", [=](int x, int y) { return noise(x, y) % 3 == 0   ? 32767
                                              : noise(x, y) % 3 == 1 ? -32000
                                                                     : none; }},
      {"any number", [=](int x, int y) { return noise(x, y) - 32768; }},
      {"noise, half rejected", [=](int x, int y) { return noise(x, y) & 1 ? noise(x, y) % 64 : none; }},
      {"noise, few rejected", [=](int x, int y) { return noise(x, y) % 10 ? noise(x, y) % 40 : none; }},
      {"noise over a slope", [=](int x, int y) { return noise(x, y) % 3 ? x / 2 + y + noise(x, y) % 30 : none - noise(x, y) % 5; }},
      {"blocks", [=](int x, int y) { return noise(x / 9, y / 7) % 4 ? noise(x / 9, y / 7) % 100 : none; }},
  };
}

inline Picture<int16_t> picture(int width, int height, const Pattern& pattern) {
  Picture<int16_t> made(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) made.at(x, y) = static_cast<int16_t>(pattern(x, y));
  return made;
}

/// `cuts`: the bands' first rows but 0, rising.
inline void filter(const Kernels& k, const SpeckleRule& rule, const std::vector<int>& cuts, SpeckleScratch& scratch, Plane<int16_t> p) {
  std::vector<int> borders{0};
  borders.insert(borders.end(), cuts.begin(), cuts.end());
  borders.push_back(p.height);
  for (size_t i = borders.size() - 1; i-- > 0;) k.speckle_label(p, rule, borders[i], borders[i + 1], scratch);
  k.speckle_join(p, rule, scratch);
  for (size_t i = 0; i + 1 < borders.size(); ++i) k.speckle_refuse(rule, borders[i], borders[i + 1], scratch, p);
}

inline std::vector<std::vector<int>> cuts_of(int height) {
  std::vector<std::vector<int>> cuts{{}};
  if (height > 1) cuts.push_back({height / 2});
  if (height > 3) cuts.push_back({1, height / 3, height - 1});
  cuts.emplace_back();
  for (int y = 1; y < height; ++y) cuts.back().push_back(y);
  return cuts;
}

inline const std::vector<std::pair<int, int>> larger_sizes = {{63, 40}, {128, 70}, {130, 33}, {200, 90}, {321, 50}};
/// Most pixels and greatest difference of a speckle.
inline std::vector<std::pair<int, int>> rules_for(int pixels) { return {{0, 16}, {1, 16}, {2, 0}, {7, 768}, {100, 16}, {pixels, 4}}; }

}  // namespace vdisp::kernels
