// chance.h: random numbers that are the same everywhere: a seeded generator, and a hash for values by place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp::sim {

/// Scrambles all bits (the finaliser of MurmurHash3).
inline uint32_t scramble(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x85ebca6bu;
  x = (x ^ (x >> 13)) * 0xc2b2ae35u;
  return x ^ (x >> 16);
}

/// SplitMix64.
class Chance {
 public:
  explicit Chance(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 0x1234567u) {}
  /// Evenly in [least, most).
  double between(double least, double most) { return least + (most - least) * static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Evenly in [0, n).
  int below(int n) { return static_cast<int>(between(0, n)); }

 private:
  uint64_t next() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  uint64_t state_;
};

}  // namespace vdisp::sim
