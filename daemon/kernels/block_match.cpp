// block_match.cpp: the plain form of block matching: running sums of columns and windows, then the least of each pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/block_match.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>

namespace vdisp::kernels {
namespace {

constexpr size_t lines(size_t bytes) { return (bytes + 63) / 64; }
constexpr size_t round_up(size_t n, size_t step) { return (n + step - 1) / step * step; }

}  // namespace

BlockScratch::BlockScratch(int width, int disparities) {
  // 21: the widest window, whose columns before the first are kept as zeros. 64 and 128: what the vector form needs around its costs.
  const size_t columns = static_cast<size_t>(width) + 2 * 21, wide = round_up(static_cast<size_t>(disparities), 64);
  columns_lines_ = lines(columns * wide);
  cost_lines_ = lines(sizeof(uint16_t) * std::max<size_t>(columns, 64) * (wide + 64));
  right_lines_ = lines(sizeof(uint16_t) * (columns + wide + 128));
  sum_lines_ = lines(sizeof(uint16_t) * wide);
  row_lines_ = lines(sizeof(int16_t) * (columns + row_margin));
  memory_.resize(columns_lines_ + cost_lines_ + right_lines_ + sum_lines_ + 4 * row_lines_);
}

namespace plain {
namespace {

int pixel_cost(const BlockSearch& s, int x, int y, int disparity) {
  const int there = s.left.width - 1 - x + disparity;
  const uint8_t l = s.left.row(y)[x], r = s.right.row(y)[there];
  if (s.cost == Cost::differences) return std::min(std::abs(l - r), s.cap);
  int bits = std::popcount(static_cast<uint8_t>(l ^ r));
  if (s.cost == Cost::hamming_two) bits += std::popcount(static_cast<uint8_t>(s.left_more.row(y)[x] ^ s.right_more.row(y)[there]));
  return bits;
}

int more(int cost, int factor) { return cost + (cost * factor >> 16); }

/// The sums of the columns of this row's windows, from those of the row before or anew.
void sum_columns(const BlockSearch& s, int row, bool fresh, int columns, uint8_t* sums) {
  const int r = s.window / 2, left = s.first_column() - r;
  for (int q = 0; q < columns; ++q) {
    for (int i = 0; i < s.disparities; ++i) {
      const int x = left + q, d = s.min_disparity + i;
      int sum = 0;
      if (fresh) {
        for (int y = row - r; y <= row + r; ++y) sum += pixel_cost(s, x, y, d);
      } else {
        sum = sums[q * s.disparities + i] + pixel_cost(s, x, row + r, d) - pixel_cost(s, x, row - r - 1, d);
      }
      sums[q * s.disparities + i] = static_cast<uint8_t>(sum);
    }
  }
}

void choose(const BlockSearch& s, const int16_t* costs, int x, const Candidates& out) {
  const int n = s.disparities, best = static_cast<int>(std::min_element(costs, costs + n) - costs);
  const int least = costs[best], limit = more(least, s.unique);
  out.index[x] = static_cast<uint16_t>(best);
  out.cost[x] = static_cast<uint16_t>(least);
  out.before[x] = static_cast<uint16_t>(costs[best > 0 ? best - 1 : best + 1]);
  out.after[x] = static_cast<uint16_t>(costs[best + 1 < n ? best + 1 : best - 1]);
  out.refused[x] = 0;
  if (s.home > 0) out.home[x] = static_cast<uint16_t>(*std::min_element(costs + s.home - 1, costs + s.home + 2));
  for (int i = 0; s.unique > 0 && i < n; ++i) {
    if (std::abs(i - best) > 1 && costs[i] <= limit) out.refused[x] = candidate_not_unique;
  }
}

}  // namespace

void match_row(const BlockSearch& s, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  const int first = s.first_column(), pixels = s.last_column() - first, n = s.disparities;
  if (pixels <= 0) return;
  uint8_t* sums = scratch.columns();
  int16_t *costs = scratch.costs(), *right = scratch.right_best();
  sum_columns(s, row, fresh, pixels + s.window - 1, sums);
  for (int i = 0; i < n; ++i) {
    int window = 0;
    for (int q = 0; q < s.window - 1; ++q) window += sums[q * n + i];
    for (int p = 0; p < pixels; ++p) {
      window += sums[(p + s.window - 1) * n + i];
      costs[p * n + i] = static_cast<int16_t>(window);
      window -= sums[p * n + i];
    }
  }
  // Pixel p at index i meets the same pixel of the right view as p + 1 at i + 1: numbered by i - p.
  std::fill_n(right, pixels + n, int16_t{INT16_MAX});
  for (int p = 0; p < pixels; ++p) {
    for (int i = 0; i < n; ++i) right[pixels - 1 - p + i] = std::min(right[pixels - 1 - p + i], costs[p * n + i]);
    choose(s, costs + p * n, first + p, out);
  }
  for (int p = 0; p < pixels; ++p) {
    const int x = first + p, i = out.index[x];
    int16_t match = static_cast<int16_t>(out.cost[x]);
    if (p > 0 && i > 0) match = std::min(match, costs[(p - 1) * n + i - 1]);
    if (p + 1 < pixels && i + 1 < n) match = std::min(match, costs[(p + 1) * n + i + 1]);
    const int best = right[pixels - 1 - p + i];
    if (more(best, s.left_right) < match) out.refused[x] |= candidate_left_right;
  }
}

}  // namespace plain
}  // namespace vdisp::kernels
