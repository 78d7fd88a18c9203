// semi_global.cpp: the plain form of semi-global matching: every path pixel by pixel.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/semi_global.h"

#include <sys/mman.h>

#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>

namespace vdisp::kernels {

SemiGlobalVolume::SemiGlobalVolume(int width, int rows, int disparities, int paths, int threads)
    : disparities_(disparities), rows_(rows), blocks_((width + block - 1) / block) {
  const size_t columns = static_cast<size_t>(blocks_) * block, n = static_cast<size_t>(disparities);
  // A byte for each column and disparity, and one for their least; of the diagonals two rows each.
  state_bytes_ = (block + 128) * (n + 1);
  const size_t states = paths == 8 ? 6 * (columns + 128) * (n + 1) : static_cast<size_t>(blocks_) * state_bytes_;
  // Step 1 holds its rows' sums turned; step 3 the sums of a block shifted against each other, the least of the right view, and costs.
  const size_t across = columns * (column_bytes(disparities) + 32) + 3 * n * rows_across,
               winners = (n + 192) * n + columns + n + 1024 + laid_out * n;
  work_bytes_ = (std::max(across, winners) + 4096) / 64 * 64;
  const size_t volume = static_cast<size_t>(rows / rows_across) * static_cast<size_t>(blocks_) * block_bytes();
  costs_ = reserve(volume);
  sums_ = reserve(volume);
  states_ = reserve(states);
  work_ = reserve(work_bytes_ * static_cast<size_t>(threads));
}

SemiGlobalVolume::Memory SemiGlobalVolume::reserve(size_t bytes) {
  bytes = (bytes + 64 + page - 1) / page * page;  // 64: the vector forms read whole vectors
  bytes_ += bytes;
  Memory memory(static_cast<uint8_t*>(::operator new[](bytes, std::align_val_t{page})));
  // Large pages, where the system has them to give: columns are turned all over this memory.
  madvise(memory.get(), bytes, MADV_HUGEPAGE);
  std::memset(memory.get(), 0, bytes);
  return memory;
}

namespace plain {
namespace {

constexpr int block = SemiGlobalVolume::block;

/// Offsets (x, y) of the pixels compared with those opposite. Dense near the centre, wide enough for faint texture.
constexpr std::array<std::array<int, 2>, 16> pairs{
    {{1, 0}, {2, 0}, {3, 0}, {4, 0}, {-2, 1}, {0, 1}, {2, 1}, {-3, 1}, {3, 1}, {-1, 2}, {1, 2}, {0, 2}, {-3, 2}, {3, 2}, {-1, 3}, {1, 3}}};

/// One disparity of one pixel in a row of the volume.
uint8_t* at(uint8_t* row, const SemiGlobalVolume& volume, int column, int i) {
  return row + static_cast<ptrdiff_t>(volume.block_bytes()) * (column / block) + i * block + column % block;
}

/// Code differences of all disparities of a pixel, summed over 3 rows. Beyond the search stands what is at its borders.
void sum_rows(const SemiGlobal& s, int row, int column, uint8_t* sums) {
  const int x = s.first_column() + std::clamp(column, 0, s.columns() - 1);
  std::fill_n(sums, s.disparities, uint8_t{0});
  for (int v = row - 1; v <= row + 1; ++v) {
    const int y = std::clamp(v, 0, s.image.height - 1);
    const int low = s.left_low.row(y)[x], high = s.left_high.row(y)[x];
    const uint8_t *there_low = s.right_low.row(y) + x - s.min_disparity, *there_high = s.right_high.row(y) + x - s.min_disparity;
    for (int i = 0; i < s.disparities; ++i) {
      const unsigned differ = static_cast<unsigned>((low ^ there_low[-i]) | (high ^ there_high[-i]) << 8);
      sums[i] = static_cast<uint8_t>(sums[i] + std::popcount(differ));
    }
  }
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

/// Costs of one disparity around a column, for the sub-pixel part.
int wide_cost(const SemiGlobalVolume& volume, int row, int column, int columns, int i) {
  int sum = 0;
  for (int tap = -sub_pixel_reach; tap <= sub_pixel_reach; tap += sub_pixel_step)
    sum += *at(volume.costs(row, 0), volume, std::clamp(column + tap, 0, columns - 1), i);
  return sum;
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
  uint8_t* const over_rows[3] = {work + 2 * n, work + 3 * n, work + 4 * n};
  for (int y = first; y < last; ++y) {
    uint8_t *costs = volume.costs(y, 0), *sums = volume.sums(y, 0);
    for (int x = -1; x <= columns && columns > 0; ++x) {
      sum_rows(s, y, x, over_rows[(x + 1) % 3]);
      for (int i = 0; x > 0 && i < n; ++i) {
        *at(costs, volume, x - 1, i) = static_cast<uint8_t>((over_rows[0][i] + over_rows[1][i] + over_rows[2][i]) / 4);
        *at(sums, volume, x - 1, i) = 0;
      }
    }
    for (int x = 0; x < columns; ++x, std::swap(here, before))
      step(s, at(costs, volume, x, 0), x > 0 ? before : nullptr, x > 0 ? jump_between(s, y, x, -1, 0) : 0, here, at(sums, volume, x, 0));
    for (int x = columns - 1; x >= 0; --x, std::swap(here, before)) {
      const bool begins = x + 1 == columns;
      step(s, at(costs, volume, x, 0), begins ? nullptr : before, begins ? 0 : jump_between(s, y, x, 1, 0), here, at(sums, volume, x, 0));
    }
  }
}

void paths_down(const SemiGlobal& s, int first_block, int last_block, int first_row, int last_row, bool up,
                const SemiGlobalVolume& volume) {
  const int n = s.disparities, rows = last_row - first_row, dy = up ? 1 : -1;
  const int first = first_block * block, last = std::min(last_block * block, s.columns()), reach = s.paths == 8 ? 1 : 0;
  const ptrdiff_t row_bytes = static_cast<ptrdiff_t>(std::max(last - first, 0)) * n;
  std::array<uint8_t, 256> before;
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int k = 0; k < rows; ++k) {
      const int y = up ? last_row - 1 - k : first_row + k;
      // Of a diagonal rows take turns; straight down a pixel's state replaces that of the pixel before.
      uint8_t* states = volume.states(first_block) + (reach ? (2 * dx + 2) * row_bytes : 0);
      uint8_t *here = states + (reach ? y % 2 * row_bytes : 0), *there = states + (reach ? (y + 1) % 2 * row_bytes : 0);
      for (int x = first; x < last; ++x) {
        const bool begins = y + dy < 0 || y + dy >= s.image.height || x + dx < 0 || x + dx >= s.columns();
        if (!begins) std::copy_n(there + static_cast<ptrdiff_t>(x + dx - first) * n, n, before.data());
        step(s, at(volume.costs(y, 0), volume, x, 0), begins ? nullptr : before.data(), begins ? 0 : jump_between(s, y, x, dx, dy),
             here + static_cast<ptrdiff_t>(x - first) * n, at(volume.sums(y, 0), volume, x, 0));
      }
    }
  }
}

void paths_row(const SemiGlobal& s, int row, bool, const SemiGlobalVolume& volume, uint8_t* work, const Candidates& out) {
  const int n = s.disparities, columns = s.columns(), first = s.first_column();
  uint8_t *sums = volume.sums(row, 0), *right = work;  // numbered by i - x, as in match_row
  std::fill_n(right, columns + n, uint8_t{255});
  for (int x = 0; x < columns; ++x) {
    int best = 0;
    for (int i = 0; i < n; ++i) {
      uint8_t& least = right[columns - 1 - x + i];
      least = std::min(least, *at(sums, volume, x, i));
      if (*at(sums, volume, x, i) < *at(sums, volume, x, best)) best = i;
    }
    const int cost = *at(sums, volume, x, best);
    out.index[first + x] = static_cast<uint16_t>(best);
    const int here = wide_cost(volume, row, x, columns, best);
    const int before = wide_cost(volume, row, x, columns, best > 0 ? best - 1 : best + 1);
    const int after = wide_cost(volume, row, x, columns, best + 1 < n ? best + 1 : best - 1);
    out.cost[first + x] = static_cast<uint16_t>(std::min({here, before, after}));
    out.before[first + x] = static_cast<uint16_t>(before);
    out.after[first + x] = static_cast<uint16_t>(after);
    out.refused[first + x] = cost > s.most ? candidate_not_unique : 0;
    for (int i = 0; s.unique > 0 && i < n; ++i)
      if (std::abs(i - best) > 1 && *at(sums, volume, x, i) <= more(cost, s.unique)) out.refused[first + x] = candidate_not_unique;
  }
  for (int x = 0; x < columns; ++x) {
    const int i = out.index[first + x];
    int match = *at(sums, volume, x, i);
    if (x > 0 && i > 0) match = std::min<int>(match, *at(sums, volume, x - 1, i - 1));
    if (x + 1 < columns && i + 1 < n) match = std::min<int>(match, *at(sums, volume, x + 1, i + 1));
    if (more(right[columns - 1 - x + i], s.left_right) < match) out.refused[first + x] |= candidate_left_right;
  }
}

}  // namespace plain
}  // namespace vdisp::kernels
