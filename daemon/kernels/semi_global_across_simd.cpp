// semi_global_across_simd.cpp: costs and the paths from left and right, 16 rows at a time, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/semi_global_across_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

// A path across goes from column to column, so its vectors hold rows: costs are turned from rows of columns to columns of rows, and the
// sums turned back. A vector of more than 16 bytes holds the same rows for several disparities n / groups apart.
HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void paths_across(const SemiGlobal& s, int row, const SemiGlobalVolume& volume, uint8_t* work) {
  plain::paths_across(s, row, volume, work);
}
#else

constexpr int rows = SemiGlobalVolume::rows_across, block = SemiGlobalVolume::block;

/// What one call works with; see SemiGlobalVolume's constructor for its size.
struct Work {
  Work(const SemiGlobal& search, const SemiGlobalVolume& volume, int first_row, uint8_t* memory)
      : s(search),
        n(search.disparities),
        columns(search.columns()),
        blocks((columns + block - 1) / block),
        first(first_row),
        column_stride(static_cast<ptrdiff_t>(SemiGlobalVolume::column_bytes(n))),
        row_stride(static_cast<ptrdiff_t>(volume.row_bytes())),
        block_stride(static_cast<ptrdiff_t>(volume.block_bytes())),
        row_costs(volume.costs(first, 0)),
        row_sums(volume.sums(first, 0)) {
    const auto take = [&memory](ptrdiff_t bytes) { return std::exchange(memory, memory + (bytes + 63) / 64 * 64); };
    costs = row_sums;
    edges = take(n * rows);
    sums = take(blocks * block * column_stride);
    jumps = take((columns + 2) * rows);
    state = take(n * rows + 128) + 64;
  }

  const SemiGlobal& s;
  int n, columns, blocks, first;
  ptrdiff_t column_stride, row_stride, block_stride;
  uint8_t *row_costs, *row_sums;  // the group's place in the volume; it has all 16 rows, also at the end of the image
  // Costs and sums by columns. A block's costs stand where its sums will: the last path is done with them by then.
  uint8_t *costs, *sums, *jumps, *state;
  uint8_t* edges;  // differences summed over 3 rows left of the columns at work
};

/// Some blocks of columns wide, few enough to stay in the nearest cache with all rows of codes they need.
constexpr int chunk = 4 * block;
struct Chunk {
  HWY_ALIGN uint8_t over_rows[rows][chunk + 2 * block];  // differences summed over 3 rows, one column to either side
  HWY_ALIGN uint8_t costs[4][rows][chunk];               // of the disparities that share a vector
  HWY_ALIGN uint8_t turned[4][rows][block];
};

/// Code differences of disparity i, summed over 3 rows, for 16 rows and as many columns from x on as a vector has lanes: put(r, sums).
template <class D, class Put>
HWY_INLINE void sum_rows(D d, const Work& w, int i, int x, const Put& put) {
  const SemiGlobal& s = w.s;
  const ptrdiff_t here = s.first_column() + x, there = here - s.min_disparity - i;
  const uint8_t *left_low = s.left_low.data + here, *left_high = s.left_high.data + here;
  const uint8_t *right_low = s.right_low.data + there, *right_high = s.right_high.data + there;
  const ptrdiff_t left_stride = s.left_low.stride, right_stride = s.right_low.stride;
  const auto difference = [&](int y) HWY_ATTR {
    const ptrdiff_t left = y * left_stride, right = y * right_stride;
    const auto low = hn::Xor(hn::LoadU(d, left_low + left), hn::LoadU(d, right_low + right));
    const auto high = hn::Xor(hn::LoadU(d, left_high + left), hn::LoadU(d, right_high + right));
    return hn::Add(hn::PopulationCount(low), hn::PopulationCount(high));
  };
  auto above = difference(std::max(w.first - 1, 0)), at = difference(w.first);
  for (int r = 0; r < rows; ++r) {
    const auto below = difference(std::min(w.first + r + 1, s.image.height - 1));
    put(r, hn::Add(hn::Add(above, at), below));
    above = at;
    at = below;
  }
}

/// The costs of disparity i in 16 rows and the columns [from, from + width): to the volume, and for turning.
template <class D>
HWY_INLINE void fill_costs(D d, const Work& w, int i, int from, int width, Chunk& c) {
  const int lanes = static_cast<int>(hn::Lanes(d)), end = std::min(width, w.columns - from);
  for (int x = 0; x < width; x += lanes)
    sum_rows(d, w, i, from + x, [&](int r, const auto& sums) HWY_ATTR { hn::StoreU(sums, d, c.over_rows[r] + block + x); });
  // Beyond the sides of the search stands what is at its borders.
  uint8_t* edge = w.edges + i * rows;
  for (int r = 0; r < rows; ++r) {
    uint8_t* sums = c.over_rows[r] + block;
    sums[-1] = from > 0 ? edge[r] : sums[0];
    edge[r] = sums[width - 1];
    sums[end] = sums[end - 1];
  }
  if (from + end < w.columns)
    sum_rows(d, w, i, from + end, [&](int r, const auto& sums) HWY_ATTR { c.over_rows[r][block + end] = hn::GetLane(sums); });
  for (int x = 0; x < width; x += lanes) {
    uint8_t* out = w.row_costs + (from + x) / block * w.block_stride + i * block + x % block;
    for (int r = 0; r < rows; ++r) {
      const uint8_t* sums = c.over_rows[r] + block + x;
      const auto sum = hn::Add(hn::Add(hn::LoadU(d, sums - 1), hn::LoadU(d, sums + 1)), hn::LoadU(d, sums));
      hn::StoreU(hn::ShiftRight<2>(sum), d, out + r * w.row_stride);
    }
  }
}

template <class D, class V>
HWY_INLINE void riffle(D d, V& a, V& b, V& lower, V& upper) {
  lower = hn::InterleaveLower(d, a, b);
  upper = hn::InterleaveUpper(d, a, b);
}

/// Four of these, and in each 128 bits rows have become columns.
template <class D, class V>
HWY_INLINE void quarter_turn(D d, V& a, V& b, V& c, V& e, V& f, V& g, V& h, V& i, V& j, V& k, V& l, V& m, V& n, V& o, V& p, V& q) {
  V a2 = a, b2 = b, c2 = c, e2 = e, f2 = f, g2 = g, h2 = h, i2 = i;
  V j2 = j, k2 = k, l2 = l, m2 = m, n2 = n, o2 = o, p2 = p, q2 = q;
  riffle(d, a2, j2, a, b);
  riffle(d, b2, k2, c, e);
  riffle(d, c2, l2, f, g);
  riffle(d, e2, m2, h, i);
  riffle(d, f2, n2, j, k);
  riffle(d, g2, o2, l, m);
  riffle(d, h2, p2, n, o);
  riffle(d, i2, q2, p, q);
}

/// from[r][lane] becomes to[lane % 16][r + lane / 16 * 16], for 16 rows `from_stride` and `to_stride` bytes apart.
template <class D>
HWY_INLINE void turn(D d, const uint8_t* from, ptrdiff_t from_stride, uint8_t* to, ptrdiff_t to_stride) {
  const auto row = [&](int r) HWY_ATTR { return hn::LoadU(d, from + r * from_stride); };
  auto a = row(0), b = row(1), c = row(2), e = row(3), f = row(4), g = row(5), h = row(6), i = row(7);
  auto j = row(8), k = row(9), l = row(10), m = row(11), n = row(12), o = row(13), p = row(14), q = row(15);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  const auto put = [&](int r, const auto& v) HWY_ATTR { hn::StoreU(v, d, to + r * to_stride); };
  put(0, a), put(1, b), put(2, c), put(3, e), put(4, f), put(5, g), put(6, h), put(7, i);
  put(8, j), put(9, k), put(10, l), put(11, m), put(12, n), put(13, o), put(14, p), put(15, q);
}

/// Blocks of 16 bytes: block j of in + i * in_stride becomes block i of out + j * out_stride, for as many as a vector has. It is its own
/// inverse.
template <class D>
HWY_INLINE void turn_blocks(D d, const uint8_t* in, ptrdiff_t in_stride, uint8_t* out, ptrdiff_t out_stride) {
  const int groups = static_cast<int>(hn::Lanes(d)) / 16;
  if (groups == 4) {
    const auto a = hn::LoadU(d, in), b = hn::LoadU(d, in + in_stride);
    const auto c = hn::LoadU(d, in + 2 * in_stride), e = hn::LoadU(d, in + 3 * in_stride);
    const auto ab_even = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a), ab_odd = hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a));
    const auto ce_even = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(e), c), ce_odd = hn::OddEvenBlocks(e, hn::SwapAdjacentBlocks(c));
    hn::StoreU(hn::ConcatLowerLower(d, ce_even, ab_even), d, out);
    hn::StoreU(hn::ConcatLowerLower(d, ce_odd, ab_odd), d, out + out_stride);
    hn::StoreU(hn::ConcatUpperUpper(d, ce_even, ab_even), d, out + 2 * out_stride);
    hn::StoreU(hn::ConcatUpperUpper(d, ce_odd, ab_odd), d, out + 3 * out_stride);
  } else if (groups == 2) {
    const auto a = hn::LoadU(d, in), b = hn::LoadU(d, in + in_stride);
    hn::StoreU(hn::ConcatLowerLower(d, b, a), d, out);
    hn::StoreU(hn::ConcatUpperUpper(d, b, a), d, out + out_stride);
  } else {
    hn::StoreU(hn::LoadU(d, in), d, out);
  }
}

/// All costs: to the volume, and turned.
template <class D>
HWY_INLINE void make_costs(D d, const Work& w) {
  const int lanes = static_cast<int>(hn::Lanes(d)), groups = lanes / 16, steps = w.n / groups;
  Chunk c;
  for (int from = 0; from < w.blocks * block; from += chunk) {
    const int width = std::min(chunk, w.blocks * block - from);
    for (int k = 0; k < steps; ++k) {
      for (int g = 0; g < groups; ++g) fill_costs(d, w, g * steps + k, from, width, c);
      for (int x = 0; x < width; x += block) {
        for (int g = 0; g < groups; ++g) {
          const uint8_t* in = w.row_costs + (from + x) / block * w.block_stride + (g * steps + k) * block;
          for (int lane = 0; lane < block; lane += lanes) turn(d, in + lane, w.row_stride, c.turned[g][0] + lane, block);
        }
        uint8_t* out = w.costs + (from + x) * w.column_stride + k * lanes;
        for (int lane = 0; lane < block; lane += lanes)
          for (int column = 0; column < 16; ++column)
            turn_blocks(d, c.turned[0][column] + lane, rows * block, out + (lane + column) * w.column_stride, 16 * w.column_stride);
      }
    }
  }
}

/// The sums of a block back to the volume.
template <class D>
HWY_INLINE void turn_back(D d, const Work& w, int b) {
  const int lanes = static_cast<int>(hn::Lanes(d)), groups = lanes / 16, steps = w.n / groups;
  HWY_ALIGN uint8_t turned[4][rows][block];
  for (int k = 0; k < steps; ++k) {
    const uint8_t* in = w.sums + b * block * w.column_stride + k * lanes;
    for (int lane = 0; lane < block; lane += lanes)
      for (int column = 0; column < 16; ++column)
        turn_blocks(d, in + (lane + column) * w.column_stride, 16 * w.column_stride, turned[0][column] + lane, rows * block);
    for (int g = 0; g < groups; ++g) {
      uint8_t* out = w.row_sums + b * w.block_stride + (g * steps + k) * block;
      for (int lane = 0; lane < block; lane += lanes) turn(d, turned[g][0] + lane, block, out + lane, w.row_stride);
    }
  }
}

/// For each column but the first what a jump from the column before costs, of 16 rows.
HWY_INLINE void fill_jumps(const Work& w) {
  for (int r = 0; r < rows; ++r) {
    const uint8_t* pixels = w.s.image.row(std::min(w.first + r, w.s.image.height - 1)) + w.s.first_column();
    for (int x = 1; x < w.columns; ++x) {
      const int step = pixels[x] > pixels[x - 1] ? pixels[x] - pixels[x - 1] : pixels[x - 1] - pixels[x];
      w.jumps[x * rows + r] = static_cast<uint8_t>(w.s.jump(step));
    }
  }
}

/// The least of each row over all groups, in all of them.
template <class D, class V>
HWY_INLINE V least_of_groups(D d, V v) {
  const size_t lanes = hn::Lanes(d);
  if (lanes > 16) v = hn::Min(v, hn::SwapAdjacentBlocks(v));
  if (lanes > 32) v = hn::Min(v, hn::ReverseBlocks(d, v));
  return v;
}

/// One path: from the left where `from_left`, else from the right, added to what is there.
template <bool from_left, class D>
HWY_INLINE void path(D d, const Work& w) {
  const int lanes = static_cast<int>(hn::Lanes(d)), groups = lanes / 16, steps = w.n / groups, half = w.s.paths == 8 ? 1 : 0;
  const auto small = hn::Set(d, static_cast<uint8_t>(w.s.small)), most = hn::Set(d, uint8_t{255});
  // Beyond the first and the last disparity there is no way.
  const auto lane = hn::Iota(d, 0);
  const auto below_first = hn::VecFromMask(d, hn::Lt(lane, hn::Set(d, uint8_t{16})));
  const auto above_last = hn::Not(hn::VecFromMask(d, hn::Lt(lane, hn::Set(d, static_cast<uint8_t>(lanes - 16)))));
  std::fill_n(w.state - 64, w.n * rows + 128, uint8_t{0});
  auto least = hn::Zero(d);
  for (int k = 0; k < w.columns; ++k) {
    const int x = from_left ? k : w.columns - 1 - k;
    const uint8_t *cost = w.costs + x * w.column_stride, *jump_at = w.jumps + (from_left ? x : x + 1) * rows;
    uint8_t* sum = w.sums + x * w.column_stride;
    const auto jump = k > 0 ? hn::SaturatedAdd(least, hn::LoadDup128(d, jump_at)) : least;
    // A group's first disparity follows the last one of the group below.
    auto below = hn::Or(hn::LoadU(d, w.state + (steps - 1) * lanes - 16), below_first);
    const auto end = hn::Or(hn::LoadU(d, w.state + 16), above_last);
    auto here = hn::LoadU(d, w.state);
    auto next_least = most;
    for (int i = 0; i < steps; ++i) {
      const auto above = i + 1 < steps ? hn::LoadU(d, w.state + (i + 1) * lanes) : end;
      auto way = hn::Min(hn::Min(here, jump), hn::SaturatedAdd(hn::Min(below, above), small));
      way = hn::SaturatedAdd(hn::Sub(way, least), hn::LoadU(d, cost + i * lanes));
      hn::StoreU(way, d, w.state + i * lanes);
      next_least = hn::Min(next_least, way);
      const auto part = half ? hn::ShiftRight<1>(way) : way;
      hn::StoreU(from_left ? part : hn::SaturatedAdd(part, hn::LoadU(d, sum + i * lanes)), d, sum + i * lanes);
      below = here;
      here = above;
    }
    least = least_of_groups(d, next_least);
    if (!from_left && x % block == 0) turn_back(d, w, x / block);
  }
}

void paths_across(const SemiGlobal& s, int row, const SemiGlobalVolume& volume, uint8_t* memory) {
  const hn::CappedTag<uint8_t, 64> d;
  const Work w(s, volume, row, memory);
  if (w.columns == 0) return;
  make_costs(d, w);
  fill_jumps(w);
  path<true>(d, w);
  path<false>(d, w);
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(paths_across);
void choose_paths_across(Kernels& table) { table.paths_across = VDISP_CHOSEN(paths_across); }
}  // namespace vdisp::kernels
#endif
