// semi_global_across_simd.cpp: costs and the paths from left and right, 16 rows at a time, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

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
        stride(blocks * block + 128),
        column_stride(static_cast<ptrdiff_t>(SemiGlobalVolume::across_stride(n))) {
    const size_t plane = SemiGlobalVolume::plane_bytes(blocks, n), turned_bytes = static_cast<size_t>(blocks * block * column_stride);
    for (uint8_t*& ring : across) ring = take(memory, plane);
    costs = take(memory, turned_bytes);
    sums = take(memory, turned_bytes);
    jumps = take(memory, static_cast<size_t>((columns + 2) * rows));
    state = take(memory, static_cast<size_t>(n * rows + 128)) + 64;
    line = take(memory, static_cast<size_t>(stride));
    for (int r = 0; r < rows; ++r) {
      const int y = std::min(first + r, s.image.height - 1);
      cost_rows[r] = volume.costs(y, 0);
      sum_rows[r] = first + r < s.image.height ? volume.sums(y, 0) : nullptr;
    }
  }
  static uint8_t* take(uint8_t*& memory, size_t bytes) {
    uint8_t* taken = memory;
    memory += (bytes + 63) / 64 * 64;
    return taken;
  }

  const SemiGlobal& s;
  int n, columns, blocks, first;
  ptrdiff_t stride, column_stride;
  uint8_t* across[3];  // three rows of costs summed over 3 columns
  uint8_t *costs, *sums, *jumps, *state, *line;
  uint8_t *cost_rows[rows], *sum_rows[rows];
};

/// One row of code differences, summed over 3 columns.
template <class D>
HWY_INLINE void sum_row(D d, const Work& w, int y, uint8_t* out) {
  const SemiGlobal& s = w.s;
  const int lanes = static_cast<int>(hn::Lanes(d)), columns = w.columns;
  const uint8_t *low = s.left_low.row(y) + s.first_column(), *high = s.left_high.row(y) + s.first_column();
  uint8_t* line = w.line + 64;
  for (int i = 0; i < w.n; ++i, out += w.stride) {
    const ptrdiff_t there = s.first_column() - s.min_disparity - i;
    const uint8_t *right_low = s.right_low.row(y) + there, *right_high = s.right_high.row(y) + there;
    for (int x = 0; x < columns; x += lanes) {
      const auto low_bits = hn::PopulationCount(hn::Xor(hn::LoadU(d, low + x), hn::LoadU(d, right_low + x)));
      const auto high_bits = hn::PopulationCount(hn::Xor(hn::LoadU(d, high + x), hn::LoadU(d, right_high + x)));
      hn::StoreU(hn::Add(low_bits, high_bits), d, line + x);
    }
    line[-1] = line[0];
    line[columns] = line[columns - 1];
    for (int x = 0; x < columns; x += lanes)
      hn::StoreU(hn::Add(hn::Add(hn::LoadU(d, line + x - 1), hn::LoadU(d, line + x)), hn::LoadU(d, line + x + 1)), d, out + x);
  }
}

/// The costs of the 16 rows.
template <class D>
HWY_INLINE void fill_costs(D d, const Work& w) {
  const int lanes = static_cast<int>(hn::Lanes(d)), height = w.s.image.height;
  for (int k = -1; k <= rows && w.first + k <= height; ++k) {
    sum_row(d, w, std::clamp(w.first + k, 0, height - 1), w.across[(k + 1) % 3]);
    if (k < 1) continue;
    for (int i = 0; i < w.n; ++i) {
      const uint8_t *a = w.across[0] + i * w.stride, *b = w.across[1] + i * w.stride, *c = w.across[2] + i * w.stride;
      uint8_t* out = w.cost_rows[k - 1] + i * block;
      for (int x = 0; x < w.blocks * block; x += lanes) {
        const auto sum = hn::Add(hn::Add(hn::LoadU(d, a + x), hn::LoadU(d, b + x)), hn::LoadU(d, c + x));
        hn::StoreU(hn::ShiftRight<2>(sum), d, out + x / block * (w.n * block) + x % block);
      }
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

/// from[r][lane] becomes to[lane % 16][r + lane / 16 * 16], for 16 rows; null rows of `to` are left out.
template <class D>
HWY_INLINE void turn(D d, const uint8_t* const* from, ptrdiff_t from_at, uint8_t* const* to, ptrdiff_t to_at) {
  const auto row = [&](int r) HWY_ATTR { return hn::LoadU(d, from[r] + from_at); };
  auto a = row(0), b = row(1), c = row(2), e = row(3), f = row(4), g = row(5), h = row(6), i = row(7);
  auto j = row(8), k = row(9), l = row(10), m = row(11), n = row(12), o = row(13), p = row(14), q = row(15);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  quarter_turn(d, a, b, c, e, f, g, h, i, j, k, l, m, n, o, p, q);
  const auto put = [&](int r, const auto& v) HWY_ATTR {
    if (to[r]) hn::StoreU(v, d, to[r] + to_at);
  };
  put(0, a), put(1, b), put(2, c), put(3, e), put(4, f), put(5, g), put(6, h), put(7, i);
  put(8, j), put(9, k), put(10, l), put(11, m), put(12, n), put(13, o), put(14, p), put(15, q);
}

/// All costs, or all sums back.
template <bool back, class D>
HWY_INLINE void turn_all(D d, const Work& w) {
  const hn::FixedTag<uint8_t, 16> d16;
  const int lanes = static_cast<int>(hn::Lanes(d)), groups = lanes / 16, steps = w.n / groups;
  HWY_ALIGN uint8_t turned[rows * block];
  uint8_t* turned_rows[rows];
  for (int r = 0; r < rows; ++r) turned_rows[r] = turned + r * block;
  for (int b = 0; b < w.blocks; ++b) {
    for (int i = 0; i < w.n; ++i) {
      // Disparity i of a column stands in lanes i / steps * 16 of vector i % steps.
      uint8_t* column = (back ? w.sums : w.costs) + b * block * w.column_stride + (i % steps * groups + i / steps) * 16;
      const ptrdiff_t at = b * block * w.n + i * block;
      if (!back)
        for (int x = 0; x < block; x += lanes) turn(d, w.cost_rows, at + x, turned_rows, x);
      for (int x = 0; x < block; ++x) {
        uint8_t *wide = column + x * w.column_stride, *narrow = turned + x % 16 * block + x / 16 * 16;
        hn::StoreU(hn::LoadU(d16, back ? wide : narrow), d16, back ? narrow : wide);
      }
      if (back)
        for (int x = 0; x < block; x += lanes) turn(d, turned_rows, x, w.sum_rows, at + x);
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
  }
}

void paths_across(const SemiGlobal& s, int row, const SemiGlobalVolume& volume, uint8_t* memory) {
  const hn::CappedTag<uint8_t, 64> d;
  const Work w(s, volume, row, memory);
  if (w.columns == 0) return;
  fill_costs(d, w);
  turn_all<false>(d, w);
  fill_jumps(w);
  path<true>(d, w);
  path<false>(d, w);
  turn_all<true>(d, w);
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
