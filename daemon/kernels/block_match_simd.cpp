// block_match_simd.cpp: block matching for all instruction sets, the disparities of a pixel side by side in a vector.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstring>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/block_match_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void match_row(const BlockSearch& search, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  plain::match_row(search, row, fresh, scratch, out);
}
#else

// Costs of the pixels at hand stand in a ring of slots, so that they stay in the first cache. Before and behind a pixel's costs lie
// `pad` words above every cost, so that the right view's best can be taken along the diagonal without asking for borders.
constexpr int slots = 64, strip = 32, block = 16, pad = 32;
constexpr uint8_t above_byte = 0x7F;  // what memset makes of it is positive in 16 bits, signed or not
constexpr int16_t above = 0x7F7F;

/// The vectors that a window's costs are summed and compared in: those of so many bytes as D8 has lanes, or half as many.
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
template <class D8>
constexpr bool in_one = hn::MaxLanes(D8()) <= 32;
#else
template <class D8>
constexpr bool in_one = false;
#endif
template <class D8>
using Words = hn::CappedTag<int16_t, in_one<D8> ? hn::MaxLanes(D8()) : hn::MaxLanes(D8()) / 2>;

void fill_above(int16_t* words, int n) { std::memset(words, above_byte, sizeof(int16_t) * static_cast<size_t>(n)); }

/// One row of one search as the loops need it. `known` is its width where that is a constant, which lets the loops be unrolled; else 0.
template <int known>
struct Row {
  const BlockSearch& s;
  int pixels, any_wide;
  uint8_t* columns;  // [column][wide]; `window` columns of zeros before
  int16_t *ring, *right, *sums, *limits, *rivals, *same, *back;
  const uint8_t *left_new, *left_old, *right_new, *right_old;  // at column first - r; the right ones for index 0
  const uint8_t *left_new2, *left_old2, *right_new2, *right_old2;
  int wide() const { return known ? known : any_wide; }  // disparities, rounded up to whole vectors
  int slot_words() const { return wide() + 2 * pad; }
  int16_t* costs(int p) const { return ring + (p & (slots - 1)) * slot_words() + pad; }
  /// costs(p + 1), given those of p.
  int16_t* next(int p, int16_t* costs) const { return (p + 1) & (slots - 1) ? costs + slot_words() : ring + pad; }
};

/// What a pixel may cost at most, and for bits which count; nothing beyond the last disparity, so that sums stay there what they were.
template <Cost cost, class D8>
HWY_INLINE hn::Vec<D8> most_of(D8 d8, const BlockSearch& s, int i) {
  const hn::RebindToSigned<D8> di8;
  const auto most = hn::Set(d8, cost == Cost::differences ? static_cast<uint8_t>(s.cap) : uint8_t{0xFF});
  const int left = std::min(s.disparities - i, 64);
  const auto inside = hn::RebindMask(d8, hn::Lt(hn::Iota(di8, 0), hn::Set(di8, static_cast<int8_t>(left))));
  return hn::IfThenElseZero(inside, most);
}

template <Cost cost, class D8, class V8 = hn::Vec<D8> >
HWY_INLINE V8 pixel_costs(D8 d8, const uint8_t* left, const uint8_t* right, const uint8_t* left2, const uint8_t* right2, V8 most) {
  const V8 l = hn::Set(d8, *left), r = hn::LoadU(d8, right);
  if constexpr (cost == Cost::differences) {
    const hn::RebindToSigned<D8> di8;
    return hn::Min(hn::BitCast(d8, hn::Abs(hn::BitCast(di8, hn::Sub(l, r)))), most);
  } else {
    V8 bits = hn::PopulationCount(hn::Xor(l, r));
    if constexpr (cost == Cost::hamming_two) bits = hn::Add(bits, hn::PopulationCount(hn::Xor(hn::Set(d8, *left2), hn::LoadU(d8, right2))));
    return hn::And(bits, most);
  }
}

/// The column sums without the window's newest row, made anew from the rows [from, to).
template <Cost cost, class D8, int known>
void begin_columns(D8 d8, const Row<known>& row, int y_from, int y_to) {
  const BlockSearch& s = row.s;
  const int n8 = static_cast<int>(hn::Lanes(d8)), columns = row.pixels + s.window - 1, left = s.first_column() - s.window / 2;
  std::memset(row.columns - static_cast<ptrdiff_t>(s.window) * row.wide(), 0, static_cast<size_t>(columns + s.window) * row.wide());
  for (int y = y_from; y < y_to; ++y) {
    const int there = s.left.width - 1 - left + s.min_disparity;
    const uint8_t *l = s.left.row(y) + left, *r = s.right.row(y) + there;
    const uint8_t* l2 = cost == Cost::hamming_two ? s.left_more.row(y) + left : l;
    const uint8_t* r2 = cost == Cost::hamming_two ? s.right_more.row(y) + there : r;
    for (int q = 0; q < columns; ++q) {
      for (int i = 0; i < row.wide(); i += n8) {
        uint8_t* to = row.columns + q * row.wide() + i;
        const auto costs = pixel_costs<cost>(d8, l + q, r - q + i, l2 + q, r2 - q + i, most_of<cost>(d8, s, i));
        hn::Store(hn::Add(hn::Load(d8, to), costs), d8, to);
      }
    }
  }
}

/// Columns [from, to): column sums brought to this row, window sums moved on, and from the first whole window on stored as costs.
template <Cost cost, bool subtract, class D8, int known>
HWY_INLINE void sum_strip(D8 d8, const Row<known>& row, int from, int to) {
  const Words<D8> d16;
  const hn::Rebind<uint8_t, Words<D8> > part8;
  const int n8 = static_cast<int>(hn::Lanes(d8)), n16 = static_cast<int>(hn::Lanes(d16)), w = row.s.window;
  const int second = in_one<D8> ? 0 : n16;
  for (int i = 0; i < row.wide(); i += n8) {
    auto sum0 = hn::Load(d16, row.sums + i), sum1 = hn::Load(d16, row.sums + i + second);
    const auto most = most_of<cost>(d8, row.s, i);
    for (int q = from; q < to; ++q) {
      uint8_t* column = row.columns + q * row.wide() + i;
      auto costs = hn::Load(d8, column);
      if constexpr (subtract) {
        costs =
            hn::Sub(costs, pixel_costs<cost>(d8, row.left_old + q, row.right_old - q + i, row.left_old2 + q, row.right_old2 - q + i, most));
      }
      costs =
          hn::Add(costs, pixel_costs<cost>(d8, row.left_new + q, row.right_new - q + i, row.left_new2 + q, row.right_new2 - q + i, most));
      hn::Store(costs, d8, column);
      const uint8_t* gone = column - static_cast<ptrdiff_t>(w) * row.wide();
      const auto change = [&](int k) HWY_ATTR {
        return hn::Sub(hn::PromoteTo(d16, hn::Load(part8, column + k)), hn::PromoteTo(d16, hn::Load(part8, gone + k)));
      };
      sum0 = hn::Add(sum0, change(0));
      if constexpr (!in_one<D8>) sum1 = hn::Add(sum1, change(n16));
      if (q < w - 1) continue;
      int16_t* to_costs = row.costs(q - (w - 1)) + i;
      hn::Store(sum0, d16, to_costs);
      if constexpr (!in_one<D8>) hn::Store(sum1, d16, to_costs + n16);
    }
    hn::Store(sum0, d16, row.sums + i);
    if constexpr (!in_one<D8>) hn::Store(sum1, d16, row.sums + i + n16);
  }
}

template <class D16, class V16 = hn::Vec<D16> >
HWY_INLINE int16_t least_of(D16 d16, V16 v) {
#if HWY_ARCH_X86
  if constexpr (hn::MaxLanes(D16()) == 8) {
    return static_cast<int16_t>(_mm_cvtsi128_si32(_mm_minpos_epu16(v.raw)));
  } else if constexpr (hn::MaxLanes(D16()) > 8) {
    const hn::Half<D16> half;
    return least_of(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
#endif
  return hn::GetLane(hn::MinOfLanes(d16, v));
}

/// What the right view's pixels cost at best, brought up to date with the pixels [from, to), at most `block` of them.
template <class D16, int known>
HWY_INLINE void take_right(D16 d16, const Row<known>& row, int from, int to) {
  const int n16 = static_cast<int>(hn::Lanes(d16)), next = row.slot_words() + 1;
  int16_t* HWY_RESTRICT right = row.right + (row.pixels - 1 - from);
  // A block does not wrap around in the ring: its pixels' costs lie one behind the other.
  const int16_t* HWY_RESTRICT costs = row.costs(from);
  for (int k = 1 - block; k < row.s.disparities; k += n16) {
    auto best = hn::LoadU(d16, right + k);
    if (to - from == block) {
      auto other = hn::LoadU(d16, costs + k);
      for (int i = 1; i < block; i += 3) {
        best = hn::Min(best, hn::LoadU(d16, costs + k + i * next));
        other = hn::Min(other, hn::LoadU(d16, costs + k + (i + 1) * next));
        best = hn::Min(best, hn::LoadU(d16, costs + k + (i + 2) * next));
      }
      best = hn::Min(best, other);
    } else {
      for (int i = 0; i < to - from; ++i) best = hn::Min(best, hn::LoadU(d16, costs + k + i * next));
    }
    hn::StoreU(best, d16, right + k);
  }
}

#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
/// Which of a pixel's first 64 costs from `costs` on are less than `limit`, or equal to it: a bit each.
template <bool equal, class D16, class V16>
HWY_INLINE uint64_t bits(D16 d16, const int16_t* costs, int n, V16 limit) {
  uint64_t all = 0;
  for (int i = 0; i < n; i += static_cast<int>(hn::Lanes(d16))) {
    const auto v = hn::Load(d16, costs + i);
    all |= static_cast<uint64_t>((equal ? hn::Eq(v, limit) : hn::Lt(v, limit)).raw) << i;
  }
  return all;
}
#endif

/// The disparity of pixel p that costs least.
template <class D16>
HWY_INLINE void choose(D16 d16, const int16_t* HWY_RESTRICT costs, int wide, int x, const Candidates& out) {
  const int n16 = static_cast<int>(hn::Lanes(d16));
  auto least = hn::Load(d16, costs);
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  for (int i = n16; i < wide; i += n16) least = hn::Min(least, hn::Load(d16, costs + i));
  const int16_t cost = least_of(d16, least);
  const auto same = hn::Set(d16, cost);
  // The lowest of them, from the highest block down: the first of the blocks has it if no other has.
  const int blocks = (wide + 63) / 64;
  int index = std::countr_zero(bits<true>(d16, costs + (blocks - 1) * 64, wide - (blocks - 1) * 64, same)) + (blocks - 1) * 64;
  for (int i = (blocks - 2) * 64; i >= 0; i -= 64) {
    const uint64_t found = bits<true>(d16, costs + i, 64, same);
    index = found ? i + std::countr_zero(found) : index;
  }
#else
  auto where = hn::Zero(d16);
  for (int i = n16; i < wide; i += n16) {
    const auto next = hn::Load(d16, costs + i);
    where = hn::IfThenElse(hn::Lt(next, least), hn::Set(d16, static_cast<int16_t>(i)), where);
    least = hn::Min(least, next);
  }
  const int16_t cost = least_of(d16, least);
  where = hn::Add(where, hn::Iota(d16, 0));
  const int index = least_of(d16, hn::IfThenElse(hn::Eq(least, hn::Set(d16, cost)), where, hn::Set(d16, above)));
#endif
  out.index[x] = static_cast<uint16_t>(index);
  out.cost[x] = static_cast<uint16_t>(cost);
  out.before[x] = static_cast<uint16_t>(costs[index - 1]);
  out.after[x] = static_cast<uint16_t>(costs[index + 1]);
}

/// How many of a pixel's costs are at most its limit.
template <class D16>
HWY_INLINE int16_t count_rivals(D16 d16, const int16_t* HWY_RESTRICT costs, int wide, int16_t limit) {
  const int n16 = static_cast<int>(hn::Lanes(d16));
  const auto limits = hn::Set(d16, static_cast<int16_t>(limit + 1));
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  int rivals = 0;
  for (int i = 0; i < wide; i += 64) rivals += std::popcount(bits<false>(d16, costs + i, std::min(wide - i, 64), limits));
  return static_cast<int16_t>(rivals);
#else
  auto rivals = hn::Zero(d16);
  for (int i = 0; i < wide; i += n16) rivals = hn::Sub(rivals, hn::VecFromMask(d16, hn::Lt(hn::Load(d16, costs + i), limits)));
  return hn::GetLane(hn::SumOfLanes(d16, rivals));
#endif
}

/// cost and a part of it.
template <class D16, class V16 = hn::Vec<D16> >
HWY_INLINE V16 more(D16 d16, V16 cost, int factor) {
  const hn::RebindToUnsigned<D16> du;
  const auto part = hn::MulHigh(hn::BitCast(du, cost), hn::Set(du, static_cast<uint16_t>(factor)));
  return hn::Add(cost, hn::BitCast(d16, part));
}

/// Chooses for the pixels [from, to), and asks how many rivals each has.
template <class D16, int known>
HWY_INLINE void choose_strip(D16 d16, const Row<known>& row, int from, int to, const Candidates& out) {
  const hn::CappedTag<int16_t, 32> wide16;
  const int first = row.s.first_column(), wide = row.wide();
  int16_t* costs = row.costs(from);
  for (int p = from; p < to; costs = row.next(p++, costs)) {
    choose(d16, costs, wide, first + p, out);
    if (row.s.home <= 0) continue;
    const int16_t* home = costs + row.s.home;
    out.home[first + p] = static_cast<uint16_t>(std::min(home[0], std::min(home[-1], home[1])));
  }
  for (int p = from; p < to; p += static_cast<int>(hn::Lanes(wide16))) {
    const auto cost = hn::LoadU(wide16, reinterpret_cast<const int16_t*>(out.cost) + first + p);
    hn::StoreU(more(wide16, cost, row.s.unique), wide16, row.limits + p);
  }
  int16_t *before = row.costs(from - 1), *here = row.costs(from);
  for (int p = from; p < to; ++p) {
    const int index = out.index[first + p];
    int16_t* after = row.next(p, here);
    row.rivals[p] = count_rivals(d16, here, wide, row.limits[p]);
    row.same[p] = std::min(before[index - 1], after[index + 1]);
    before = here;
    here = after;
  }
}

/// The whole row's refusals, and neighbours where the search ends.
template <int known>
void refuse(const Row<known>& row, const Candidates& out) {
  const hn::CappedTag<int16_t, 32> d16;
  const int first = row.s.first_column();
  for (int p = 0; p < row.pixels; ++p) row.back[p] = row.right[row.pixels - 1 - p + out.index[first + p]];
  const auto over = hn::Set(d16, above), one = hn::Set(d16, int16_t{1}), zero = hn::Zero(d16);
  const auto unique = hn::Set(d16, row.s.unique > 0 ? static_cast<int16_t>(candidate_not_unique) : int16_t{0});
  const auto left_right = hn::Set(d16, static_cast<int16_t>(candidate_left_right));
  for (int p = 0; p < row.pixels; p += static_cast<int>(hn::Lanes(d16))) {
    const auto at = [&](uint16_t* from) { return reinterpret_cast<int16_t*>(from) + first + p; };
    const auto cost = hn::LoadU(d16, at(out.cost)), before = hn::LoadU(d16, at(out.before)), after = hn::LoadU(d16, at(out.after));
    const auto limit = hn::LoadU(d16, row.limits + p);
    // Compares are -1 where true: the rivals less the neighbours among them, and less itself.
    const auto own = [&](auto neighbour) { return hn::IfThenElse(hn::Gt(neighbour, limit), zero, one); };
    const auto rivals = hn::Sub(hn::Sub(hn::LoadU(d16, row.rivals + p), own(before)), own(after));
    const auto back = more(d16, hn::LoadU(d16, row.back + p), row.s.left_right);
    const auto elsewhere = hn::Lt(back, hn::Min(cost, hn::LoadU(d16, row.same + p)));
    const auto refused = hn::Or(hn::IfThenElseZero(hn::Gt(rivals, one), unique), hn::IfThenElseZero(elsewhere, left_right));
    hn::StoreU(refused, d16, at(out.refused));
    hn::StoreU(hn::IfThenElse(hn::Eq(before, over), after, before), d16, at(out.before));
    hn::StoreU(hn::IfThenElse(hn::Eq(after, over), before, after), d16, at(out.after));
  }
}

template <Cost cost, int known, class D8>
void match_wide(D8 d8, const BlockSearch& s, int y, bool fresh, BlockScratch& scratch, const Candidates& out) {
  const Words<D8> d16;
  const int n8 = static_cast<int>(hn::Lanes(d8)), r = s.window / 2, first = s.first_column(), left = first - r;
  const int pixels = s.last_column() - first, wide = known ? known : (s.disparities + n8 - 1) / n8 * n8;
  const int there = s.left.width - 1 - left + s.min_disparity, old = std::max(y - r - 1, 0);
  const bool two = cost == Cost::hamming_two;
  const View8 left2 = two ? s.left_more : s.left, right2 = two ? s.right_more : s.right;
  const Row<known> row{s,
                       pixels,
                       wide,
                       scratch.columns() + static_cast<ptrdiff_t>(s.window) * wide,
                       scratch.costs(),
                       scratch.right_best() + pad,
                       scratch.sums(),
                       scratch.row(0),
                       scratch.row(1),
                       scratch.row(2),
                       scratch.row(3),
                       s.left.row(y + r) + left,
                       s.left.row(old) + left,
                       s.right.row(y + r) + there,
                       s.right.row(old) + there,
                       left2.row(y + r) + left,
                       left2.row(old) + left,
                       right2.row(y + r) + there,
                       right2.row(old) + there};
  if (fresh) {
    fill_above(row.ring, slots * row.slot_words());
    begin_columns<cost>(d8, row, y - r, y + r);
  }
  // What lies beyond the last disparity must never be the least.
  std::fill_n(row.sums, s.disparities, int16_t{0});
  fill_above(row.sums + s.disparities, wide - s.disparities);
  fill_above(row.right - pad, pixels + wide + 2 * pad);
  fill_above(row.costs(-1), wide);

  const auto sum = [&](int from, int to) { fresh ? sum_strip<cost, false>(d8, row, from, to) : sum_strip<cost, true>(d8, row, from, to); };
  sum(0, s.window - 1);
  for (int p = 0; p < pixels; p += strip) {
    const int end = std::min(p + strip, pixels);
    sum(p + s.window - 1, end + s.window - 1);
    for (int b = p; b < end; b += block) take_right(d16, row, b, std::min(b + block, end));
    if (end == pixels) fill_above(row.costs(pixels), wide);
    const int chosen = end == pixels ? end : end - 1;
    choose_strip(d16, row, std::max(p - 1, 0), chosen, out);
  }
  refuse(row, out);
}

template <Cost cost, class D8>
void match(D8 d8, const BlockSearch& s, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  const int n8 = static_cast<int>(hn::Lanes(d8)), wide = (s.disparities + n8 - 1) / n8 * n8;
  if (wide == static_cast<int>(hn::MaxLanes(D8())))
    return match_wide<cost, static_cast<int>(hn::MaxLanes(D8()))>(d8, s, row, fresh, scratch, out);
  if (cost == Cost::differences && wide == 48) return match_wide<cost, 48>(d8, s, row, fresh, scratch, out);
  if (cost == Cost::differences && wide == 64) return match_wide<cost, 64>(d8, s, row, fresh, scratch, out);
  if (cost == Cost::differences && wide == 128) return match_wide<cost, 128>(d8, s, row, fresh, scratch, out);
  match_wide<cost, 0>(d8, s, row, fresh, scratch, out);
}

template <Cost cost>
void match(const BlockSearch& s, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  if (s.disparities <= 16) return match<cost>(hn::CappedTag<uint8_t, 16>(), s, row, fresh, scratch, out);
  if (s.disparities <= 32) return match<cost>(hn::CappedTag<uint8_t, 32>(), s, row, fresh, scratch, out);
  match<cost>(hn::CappedTag<uint8_t, 64>(), s, row, fresh, scratch, out);
}

void match_row(const BlockSearch& s, int row, bool fresh, BlockScratch& scratch, const Candidates& out) {
  if (s.last_column() <= s.first_column()) return;
  switch (s.cost) {
    case Cost::differences: return match<Cost::differences>(s, row, fresh, scratch, out);
    case Cost::hamming: return match<Cost::hamming>(s, row, fresh, scratch, out);
    case Cost::hamming_two: return match<Cost::hamming_two>(s, row, fresh, scratch, out);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(match_row);
void choose_block_match(Kernels& table) { table.match_row = VDISP_CHOSEN(match_row); }
}  // namespace vdisp::kernels
#endif
