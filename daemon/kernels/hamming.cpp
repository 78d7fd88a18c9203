// hamming.cpp: the plain form of matching census images.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/hamming.h"

#include <algorithm>
#include <bit>

namespace vdisp::kernels::plain {
namespace {

int cost(const HammingSearch& s, int x, int y, int d) {
  const int r = s.window / 2;
  int bits = 0;
  for (int i = -r; i <= r; ++i) {
    const uint8_t *left = s.left.row(y + i) + x, *right = s.right.row(y + i) + x - d;
    for (int j = -r; j <= r; ++j) bits += std::popcount(static_cast<uint8_t>(left[j] ^ right[j]));
  }
  return bits;
}

int16_t match(const HammingSearch& s, int x, int y) {
  int best = cost(s, x, y, 0), where = 0, all = best;
  for (int d = 1; d < s.disparities; ++d) {
    const int now = cost(s, x, y, d);
    all += now;
    if (now < best) best = now, where = d;
  }
  return all - s.disparities * best < s.confidence ? s.refused : static_cast<int16_t>(16 * where);
}

}  // namespace

void match_hamming(const HammingSearch& s, int first, int last, HammingScratch&, Plane<int16_t> out) {
  const int r = s.window / 2;
  for (int y = first; y < last; ++y) {
    std::fill_n(out.row(y), out.width, s.outside);
    if (y < r || y >= s.left.height - r) continue;
    for (int x = s.first_column(); x < s.last_column(); ++x) out.row(y)[x] = match(s, x, y);
  }
}

}  // namespace vdisp::kernels::plain
