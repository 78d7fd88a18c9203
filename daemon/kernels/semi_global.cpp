// semi_global.cpp: the plain form of semi-global matching: every path pixel by pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/semi_global.h"

#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <new>
#include <sys/mman.h>

namespace vdisp::kernels {

SemiGlobalVolume::SemiGlobalVolume(int width, int height, int disparities, int threads) : disparities_(disparities) {
  blocks_ = (width + block - 1) / block;
  // 64: rows 4096 bytes apart would share the same few lines of a cache.
  stride_ = static_cast<size_t>(blocks_) * block * disparities + 64;
  // Step 1 holds three rows of sums across and twice the costs of its rows turned; step 2 two states a path; step 3 the sums of a block
  // shifted against each other.
  const size_t columns = static_cast<size_t>(blocks_) * block, plane = plane_bytes(blocks_, disparities);
  const size_t across = 3 * plane + 2 * columns * across_stride(disparities) + columns * 32;
  const size_t down = 6 * plane + 8 * columns;
  work_bytes_ = (std::max(across, down) + static_cast<size_t>(disparities) * 600 + 65536) / 64 * 64;
  const auto reserve = [this](size_t bytes) {
    bytes_ += bytes;
    bytes=(bytes+(1<<21)-1)>>21<<21; Memory memory(static_cast<uint8_t*>(::operator new[](bytes, std::align_val_t{1<<21})));
    madvise(memory.get(), bytes, 14);
    std::memset(memory.get(), 0, bytes);
    return memory;
  };
  // 64: the vector forms read whole vectors.
  costs_ = reserve(stride_ * static_cast<size_t>(height) + 64);
  sums_ = reserve(stride_ * static_cast<size_t>(height) + 64);
  work_ = reserve(work_bytes_ * static_cast<size_t>(threads));
}

namespace plain {
namespace {

constexpr int block = SemiGlobalVolume::block;

/// Offsets (x, y) of the pixels compared with those opposite. Dense near the centre, wide enough for faint texture.
constexpr std::array<std::array<int, 2>, 16> pairs{{{1, 0}, {2, 0}, {3, 0}, {4, 0}, {-2, 1}, {0, 1}, {2, 1}, {-3, 1},
                                                    {3, 1}, {-1, 2}, {1, 2}, {0, 2}, {-3, 2}, {3, 2}, {-1, 3}, {1, 3}}};

uint8_t* at(uint8_t* row, int column, int disparities, int i) {
  return row + static_cast<ptrdiff_t>(column / block) * block * disparities + i * block + column % block;
}

int code_cost(const SemiGlobal& s, int row, int column, int i) {
  const int y = std::clamp(row, 0, s.image.height - 1), x = s.first_column() + std::clamp(column, 0, s.columns() - 1);
  const int there = x - s.min_disparity - i;
  return std::popcount(static_cast<uint8_t>(s.left_low.row(y)[x] ^ s.right_low.row(y)[there])) +
         std::popcount(static_cast<uint8_t>(s.left_high.row(y)[x] ^ s.right_high.row(y)[there]));
}

/// What a path adds to the sums; `before` is the path's state one pixel back, null where the path begins.
void step(const SemiGlobal& s, const uint8_t* cost, const uint8_t* before, int jump, uint8_t* state, uint8_t* sum) {
  const int n = s.disparities;
  const int least = before ? *std::min_element(before, before + n) : 0;
  for (int i = 0; i < n; ++i) {
    int way = 0;
    if (before) {
      way = std::min<int>(before[i], least + jump);
      if (i > 0) way = std::min(way, before[i - 1] + s.small);
      if (i + 1 < n) way = std::min(way, before[i + 1] + s.small);
      way -= least;
    }
    state[i] = static_cast<uint8_t>(std::min(cost[i * block] + way, 255));
    sum[i * block] = static_cast<uint8_t>(std::min(sum[i * block] + (s.paths == 8 ? state[i] / 2 : state[i]), 255));
  }
}

int jump_between(const SemiGlobal& s, int row, int column, int dx, int dy) {
  const int x = s.first_column() + column;
  return s.jump(std::abs(s.image.row(row)[x] - s.image.row(row + dy)[x + dx]));
}

int more(int cost, int factor) { return std::min(cost + (cost * factor >> 16), 255); }

}  // namespace

void sparse_census(View8 image, int first, int last, Plane<uint8_t> low, Plane<uint8_t> high) {
  const auto pixel = [&](int x, int y) { return image.row(std::clamp(y, 0, image.height - 1))[std::clamp(x, 0, image.width - 1)]; };
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < image.width; ++x) {
      int code = 0;
      for (size_t i = 0; i < pairs.size(); ++i)
        code |= (pixel(x + pairs[i][0], y + pairs[i][1]) < pixel(x - pairs[i][0], y - pairs[i][1])) << i;
      low.row(y)[x] = static_cast<uint8_t>(code & 255);
      high.row(y)[x] = static_cast<uint8_t>(code >> 8);
    }
  }
}

void paths_across(const SemiGlobal& s, int first, const SemiGlobalVolume& volume, uint8_t* work) {
  const int last = std::min(first + SemiGlobalVolume::rows_across, s.image.height), n = s.disparities, columns = s.columns();
  uint8_t *here = work, *before = work + n;
  for (int y = first; y < last; ++y) {
    uint8_t *costs = volume.costs(y, 0), *sums = volume.sums(y, 0);
    for (int x = 0; x < columns; ++x) {
      for (int i = 0; i < n; ++i) {
        int cost = 0;
        for (int v = y - 1; v <= y + 1; ++v)
          for (int u = x - 1; u <= x + 1; ++u) cost += code_cost(s, v, u, i);
        *at(costs, x, n, i) = static_cast<uint8_t>(cost / 4);
        *at(sums, x, n, i) = 0;
      }
    }
    for (int x = 0; x < columns; ++x, std::swap(here, before))
      step(s, at(costs, x, n, 0), x > 0 ? before : nullptr, x > 0 ? jump_between(s, y, x, -1, 0) : 0, here, at(sums, x, n, 0));
    for (int x = columns - 1; x >= 0; --x, std::swap(here, before)) {
      const bool begins = x + 1 == columns;
      step(s, at(costs, x, n, 0), begins ? nullptr : before, begins ? 0 : jump_between(s, y, x, 1, 0), here, at(sums, x, n, 0));
    }
  }
}

void paths_down(const SemiGlobal& s, int first_block, int last_block, const SemiGlobalVolume& volume, uint8_t* work) {
  const int n = s.disparities, height = s.image.height;
  const int first = first_block * block, last = std::min(last_block * block, s.columns()), reach = s.paths == 8 ? 1 : 0;
  const ptrdiff_t row_bytes = static_cast<ptrdiff_t>(std::max(last - first, 0)) * n;
  for (int dy : {-1, 1}) {
    for (int dx = -reach; dx <= reach; ++dx) {
      uint8_t *here = work, *before = work + row_bytes;
      for (int k = 0; k < height; ++k, std::swap(here, before)) {
        const int y = dy < 0 ? k : height - 1 - k;
        for (int x = first; x < last; ++x) {
          const bool begins = k == 0 || x + dx < 0 || x + dx >= s.columns();
          const uint8_t* from = begins ? nullptr : before + static_cast<ptrdiff_t>(x + dx - first) * n;
          step(s, at(volume.costs(y, 0), x, n, 0), from, begins ? 0 : jump_between(s, y, x, dx, dy),
               here + static_cast<ptrdiff_t>(x - first) * n, at(volume.sums(y, 0), x, n, 0));
        }
      }
    }
  }
}

void paths_row(const SemiGlobal& s, int row, const SemiGlobalVolume& volume, uint8_t* work, const Candidates& out) {
  const int n = s.disparities, columns = s.columns(), first = s.first_column();
  uint8_t *sums = volume.sums(row, 0), *right = work;  // numbered by i - x, as in match_row
  std::fill_n(right, columns + n, uint8_t{255});
  for (int x = 0; x < columns; ++x) {
    int best = 0;
    for (int i = 0; i < n; ++i) {
      uint8_t& least = right[columns - 1 - x + i];
      least = std::min(least, *at(sums, x, n, i));
      if (*at(sums, x, n, i) < *at(sums, x, n, best)) best = i;
    }
    const int cost = *at(sums, x, n, best);
    out.index[first + x] = static_cast<uint16_t>(best);
    out.cost[first + x] = static_cast<uint16_t>(cost);
    out.before[first + x] = *at(sums, x, n, best > 0 ? best - 1 : best + 1);
    out.after[first + x] = *at(sums, x, n, best + 1 < n ? best + 1 : best - 1);
    out.refused[first + x] = 0;
    for (int i = 0; s.unique > 0 && i < n; ++i)
      if (std::abs(i - best) > 1 && *at(sums, x, n, i) <= more(cost, s.unique)) out.refused[first + x] = candidate_not_unique;
  }
  for (int x = 0; x < columns; ++x) {
    const int i = out.index[first + x];
    int match = out.cost[first + x];
    if (x > 0 && i > 0) match = std::min<int>(match, *at(sums, x - 1, n, i - 1));
    if (x + 1 < columns && i + 1 < n) match = std::min<int>(match, *at(sums, x + 1, n, i + 1));
    if (more(right[columns - 1 - x + i], s.left_right) < match) out.refused[first + x] |= candidate_left_right;
  }
}

}  // namespace plain
}  // namespace vdisp::kernels
