// semi_global_row_simd.cpp: the winners of a row of path sums, and what its filters ask, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/semi_global_row_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void paths_row(const SemiGlobal& s, int row, bool fresh, const SemiGlobalVolume& volume, uint8_t* work, const Candidates& out) {
  plain::paths_row(s, row, fresh, volume, work, out);
}
#else

constexpr int block = SemiGlobalVolume::block;

int more(int cost, int factor) { return std::min(cost + (cost * factor >> 16), 255); }

/// The best of each pixel of a block, what it and the disparities beside it cost, and whether it has a rival.
struct Winners {
  HWY_ALIGN uint8_t index[block], cost[block], before[block], after[block], refused[block];
};

// A block's costs, and of the blocks beside it what the pixels at its sides reach.
constexpr int beside = SemiGlobalVolume::beside, costs_stride = SemiGlobalVolume::laid_out;
static_assert(beside >= sub_pixel_reach);

/// The costs of block b for all disparities, with the columns to either side; beyond the search stands what is at its borders.
void lay_out_costs(const SemiGlobal& s, const SemiGlobalVolume& volume, int row, int b, uint8_t* to) {
  const uint8_t* from = volume.costs(row, b);
  const ptrdiff_t next = static_cast<ptrdiff_t>(volume.block_bytes());
  const int valid = s.columns() - b * block;
  for (int i = 0; i < s.disparities; ++i, from += block, to += costs_stride) {
    std::memcpy(to + beside, from, block);
    if (b > 0) {
      std::memcpy(to, from - next + block - beside, beside);
    } else {
      std::memset(to, from[0], beside);
    }
    if (valid >= block + beside) {
      std::memcpy(to + beside + block, from + next, beside);
    } else {
      if (valid > block) std::memcpy(to + beside + block, from + next, beside);
      const uint8_t last = to[beside + valid - 1];
      std::memset(to + beside + valid, last, static_cast<size_t>(block + beside - valid));
    }
  }
}

/// Costs from x on, summed as PathsRow says.
template <class D>
HWY_INLINE hn::Vec<D> wide_cost(D d, const uint8_t* costs, int x) {
  auto sum = hn::LoadU(d, costs + beside + x);
  for (int tap = sub_pixel_step; tap <= sub_pixel_reach; tap += sub_pixel_step)
    sum = hn::Add(sum, hn::Add(hn::LoadU(d, costs + beside + x - tap), hn::LoadU(d, costs + beside + x + tap)));
  return sum;
}

/// Costs with the part `factor` of them added.
template <class D>
HWY_INLINE hn::Vec<D> with_more(D d, hn::Vec<D> cost, int factor) {
  const hn::Half<D> half;
  const hn::Rebind<uint16_t, decltype(half)> d16;
  const hn::Rebind<int16_t, decltype(half)> i16;
  const auto part = hn::Set(d16, static_cast<uint16_t>(factor));
  const auto low = hn::PromoteTo(d16, hn::LowerHalf(half, cost)), high = hn::PromoteTo(d16, hn::UpperHalf(half, cost));
  const auto low_more = hn::DemoteTo(half, hn::BitCast(i16, hn::Add(low, hn::MulHigh(low, part))));
  const auto high_more = hn::DemoteTo(half, hn::BitCast(i16, hn::Add(high, hn::MulHigh(high, part))));
  return hn::Combine(d, high_more, low_more);
}

/// `sums`: those of a block; columns from `valid` on are none; `costs`: laid out. Writes each sum where the pixel of the right view stands
/// that it is about: column x of disparity i to x - i + n - 1 of `shifted`'s row i.
template <class D>
HWY_INLINE void find_winners(D d, const SemiGlobal& s, const uint8_t* sums, const uint8_t* costs, int valid, uint8_t* shifted,
                             ptrdiff_t stride, Winners& out) {
  const int lanes = static_cast<int>(hn::Lanes(d)), n = s.disparities;
  const auto most = hn::Set(d, uint8_t{255}), one = hn::Set(d, uint8_t{1});
  for (int x = 0; x < block; x += lanes) {
    const auto lane = hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<uint8_t>(x)));
    const auto none = hn::Not(hn::VecFromMask(d, hn::Lt(lane, hn::Set(d, static_cast<uint8_t>(valid)))));
    auto least = hn::LoadU(d, sums + x), best = hn::Zero(d), i_now = hn::Zero(d);
    auto wide = wide_cost(d, costs, x), cost = wide, before = wide_cost(d, costs + costs_stride, x);
    hn::StoreU(hn::Or(least, none), d, shifted + x + n - 1);
    // What costs least more than 1 px from the best: all up to two before it, and all from two behind it on.
    auto rival = most, two_before = most, one_before = most, last = least, last_wide = wide, after = wide;
    auto was_best = hn::Eq(i_now, i_now);
    for (int i = 1; i < n; ++i) {
      const auto sum = hn::LoadU(d, sums + i * block + x);
      hn::StoreU(hn::Or(sum, none), d, shifted + i * stride + x + n - 1 - i);
      wide = wide_cost(d, costs + i * costs_stride, x);
      i_now = hn::Add(i_now, one);
      after = hn::IfThenElse(was_best, wide, after);
      rival = hn::IfThenElse(was_best, rival, hn::Min(rival, sum));
      two_before = one_before;                 // least of 0 .. i - 2
      one_before = hn::Min(one_before, last);  // least of 0 .. i - 1
      const auto is_best = hn::Lt(sum, least);
      rival = hn::IfThenElse(is_best, two_before, rival);
      before = hn::IfThenElse(is_best, last_wide, before);
      cost = hn::IfThenElse(is_best, wide, cost);
      best = hn::IfThenElse(is_best, i_now, best);
      least = hn::Min(least, sum);
      was_best = is_best;
      last = sum;
      last_wide = wide;
    }
    after = hn::IfThenElse(was_best, before, after);
    const auto alone = hn::SaturatedSub(rival, with_more(d, least, s.unique));
    const auto rivalled = hn::VecFromMask(d, hn::Eq(s.unique > 0 ? alone : most, hn::Zero(d)));
    const auto believed = hn::VecFromMask(d, hn::Eq(hn::SaturatedSub(least, hn::Set(d, static_cast<uint8_t>(s.most))), hn::Zero(d)));
    hn::StoreU(best, d, out.index + x);
    hn::StoreU(hn::Min(cost, hn::Min(before, after)), d, out.cost + x);
    hn::StoreU(before, d, out.before + x);
    hn::StoreU(after, d, out.after + x);
    hn::StoreU(hn::And(hn::Or(rivalled, hn::Not(believed)), one), d, out.refused + x);
  }
}

/// The least of all disparities for each pixel of the right view that a block can match.
template <class D>
HWY_INLINE void take_least(D d, const uint8_t* shifted, ptrdiff_t stride, int n, uint8_t* right) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int q = 0; q < block + n; q += lanes) {
    auto least = hn::LoadU(d, right + q);
    for (int i = 0; i < n; ++i) least = hn::Min(least, hn::LoadU(d, shifted + i * stride + q));
    hn::StoreU(least, d, right + q);
  }
}

/// Copies a block's bytes to 16 bits.
template <class D>
HWY_INLINE void widen(D d16, const uint8_t* from, int count, uint16_t* to) {
  const hn::Rebind<uint8_t, D> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  int x = 0;
  for (; x + lanes <= count; x += lanes) hn::StoreU(hn::PromoteTo(d16, hn::LoadU(d8, from + x)), d16, to + x);
  for (; x < count; ++x) to[x] = from[x];
}

void paths_row(const SemiGlobal& s, int row, bool fresh, const SemiGlobalVolume& volume, uint8_t* work, const Candidates& out) {
  const hn::CappedTag<uint8_t, 64> d;
  const hn::CappedTag<uint16_t, 32> d16;
  const int n = s.disparities, columns = s.columns(), first = s.first_column(), blocks = (columns + block - 1) / block;
  const ptrdiff_t stride = (block + n + 63) / 64 * 64 + 64;
  // SemiGlobalVolume's constructor knows the size of these.
  uint8_t *shifted = work, *right = work + stride * n, *costs = right + blocks * block + n + 2 * block;
  // Each row writes the same places of it.
  if (fresh) std::memset(shifted, 255, static_cast<size_t>(stride * n));
  std::memset(right, 255, static_cast<size_t>(blocks * block + n + block));
  Winners winners;
  for (int b = 0; b < blocks; ++b) {
    const int valid = std::min(columns - b * block, block), x = first + b * block;
    lay_out_costs(s, volume, row, b, costs);
    find_winners(d, s, volume.sums(row, b), costs, valid, shifted, stride, winners);
    take_least(d, shifted, stride, n, right + b * block);
    widen(d16, winners.index, valid, out.index + x);
    widen(d16, winners.cost, valid, out.cost + x);
    widen(d16, winners.before, valid, out.before + x);
    widen(d16, winners.after, valid, out.after + x);
    widen(d16, winners.refused, valid, out.refused + x);
  }
  const uint8_t* sums = volume.sums(row, 0);
  const ptrdiff_t block_bytes = static_cast<ptrdiff_t>(volume.block_bytes());
  const auto at = [sums, block_bytes](int x, int i) { return sums[x / block * block_bytes + i * block + x % block]; };
  for (int x = 0; x < columns; ++x) {
    const int i = out.index[first + x];
    int match = at(x, i);
    if (x > 0 && i > 0) match = std::min<int>(match, at(x - 1, i - 1));
    if (x + 1 < columns && i + 1 < n) match = std::min<int>(match, at(x + 1, i + 1));
    if (more(right[x - i + n - 1], s.left_right) < match) out.refused[first + x] |= candidate_left_right;
  }
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(paths_row);
void choose_paths_row(Kernels& table) { table.paths_row = VDISP_CHOSEN(paths_row); }
}  // namespace vdisp::kernels
#endif
