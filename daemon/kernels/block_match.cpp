// block_match.cpp: the plain form of block matching: running sums of columns and windows, then the least of each pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/block_match.h"

#include <algorithm>

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

int more(int cost, int factor) { return cost + (cost * factor >> 16); }

uint8_t bits_of(uint8_t x) {
  x = static_cast<uint8_t>(x - (x >> 1 & 0x55));
  x = static_cast<uint8_t>((x & 0x33) + (x >> 2 & 0x33));
  return (x + (x >> 4)) & 0x0F;
}

/// Adds what the columns cost in row y to their sums, or takes it from them.
template <Cost cost, int sign>
void add_row(const BlockSearch& s, int y, int columns, uint8_t* sums) {
  const int n = s.disparities, first = s.first_column() - s.window / 2, there = s.left.width - 1 - first + s.min_disparity;
  const bool two = cost == Cost::hamming_two;
  const uint8_t *left = s.left.row(y) + first, *right = s.right.row(y) + there;
  const uint8_t *left2 = two ? s.left_more.row(y) + first : left, *right2 = two ? s.right_more.row(y) + there : right;
  const uint8_t cap = static_cast<uint8_t>(s.cap);
  for (int q = 0; q < columns; ++q, sums += n, --right, --right2) {
    const uint8_t l = left[q], l2 = left2[q];
    for (int i = 0; i < n; ++i) {
      uint8_t c;
      if constexpr (cost == Cost::differences) {
        const uint8_t r = right[i];
        c = std::min(static_cast<uint8_t>(std::max(l, r) - std::min(l, r)), cap);
      } else {
        c = bits_of(l ^ right[i]);
        if constexpr (cost == Cost::hamming_two) c = static_cast<uint8_t>(c + bits_of(l2 ^ right2[i]));
      }
      sums[i] = static_cast<uint8_t>(sums[i] + sign * c);
    }
  }
}

/// The sums of the columns of this row's windows, from those of the row before or anew.
template <Cost cost>
void sum_columns(const BlockSearch& s, int row, bool fresh, int columns, uint8_t* sums) {
  const int r = s.window / 2;
  if (fresh) {
    std::fill_n(sums, columns * s.disparities, uint8_t{0});
    for (int y = row - r; y < row + r; ++y) add_row<cost, 1>(s, y, columns, sums);
  } else {
    add_row<cost, -1>(s, row - r - 1, columns, sums);
  }
  add_row<cost, 1>(s, row + r, columns, sums);
}

void sum_windows(const BlockSearch& s, int pixels, const uint8_t* sums, int16_t* costs) {
  const int n = s.disparities;
  std::fill_n(costs, n, int16_t{0});
  for (int q = 0; q < s.window; ++q)
    for (int i = 0; i < n; ++i) costs[i] = static_cast<int16_t>(costs[i] + sums[q * n + i]);
  for (int p = 1; p < pixels; ++p) {
    const uint8_t *gone = sums + (p - 1) * n, *come = gone + s.window * n;
    const int16_t* before = costs + (p - 1) * n;
    int16_t* here = costs + p * n;
    for (int i = 0; i < n; ++i) here[i] = static_cast<int16_t>(before[i] + come[i] - gone[i]);
  }
}

void choose(const BlockSearch& s, const int16_t* costs, int x, const Candidates& out) {
  const int n = s.disparities;
  int16_t least = costs[0], rivals = 0;
  for (int i = 1; i < n; ++i) least = std::min(least, costs[i]);
  const int best = static_cast<int>(std::find(costs, costs + n, least) - costs), limit = more(least, s.unique);
  for (int i = 0; i < n; ++i) rivals = static_cast<int16_t>(rivals + (costs[i] <= static_cast<int16_t>(limit)));
  for (int i = std::max(best - 1, 0); i <= std::min(best + 1, n - 1); ++i) rivals = static_cast<int16_t>(rivals - (costs[i] <= limit));
  out.index[x] = static_cast<uint16_t>(best);
  out.cost[x] = static_cast<uint16_t>(least);
  out.before[x] = static_cast<uint16_t>(costs[best > 0 ? best - 1 : best + 1]);
  out.after[x] = static_cast<uint16_t>(costs[best + 1 < n ? best + 1 : best - 1]);
  out.refused[x] = s.unique > 0 && rivals > 0 ? candidate_not_unique : 0;
  if (s.home > 0) out.home[x] = static_cast<uint16_t>(*std::min_element(costs + s.home - 1, costs + s.home + 2));
}

}  // namespace

void match_row(const BlockSearch& s, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  const int first = s.first_column(), pixels = s.last_column() - first, n = s.disparities, columns = pixels + s.window - 1;
  if (pixels <= 0) return;
  uint8_t* sums = scratch.columns();
  int16_t *costs = scratch.costs(), *right = scratch.right_best();
  switch (s.cost) {
    case Cost::differences: sum_columns<Cost::differences>(s, row, fresh, columns, sums); break;
    case Cost::hamming: sum_columns<Cost::hamming>(s, row, fresh, columns, sums); break;
    case Cost::hamming_two: sum_columns<Cost::hamming_two>(s, row, fresh, columns, sums); break;
  }
  sum_windows(s, pixels, sums, costs);
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
