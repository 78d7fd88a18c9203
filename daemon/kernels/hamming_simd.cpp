// hamming_simd.cpp: matching census images for all instruction sets: pixels of a row side by side, one shift after the other.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/hamming_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void match_hamming(const HammingSearch& s, int first, int last, HammingScratch& scratch, Plane<int16_t> out) {
  plain::match_hamming(s, first, last, scratch, out);
}
#else

using D8 = hn::ScalableTag<uint8_t>;
using D16 = hn::Repartition<uint16_t, D8>;
using S16 = hn::Repartition<int16_t, D8>;

/// One band's rows. Place i of a line is column disparities - 1 + i: the first that has all its shifts.
struct Band {
  const HammingSearch& s;
  size_t line;
  uint8_t *left_new, *left_old, *right_new, *right_old;  // copies of rows, so that reading on behind their end harms nobody
  uint8_t* columns;                                      // for each shift and column the sum over the window's rows
  uint16_t* all;                                         // for each column the sum of those over the shifts
  int16_t *best, *where;                                 // of each pixel
  int places;                                            // columns

  Band(const HammingSearch& search, HammingScratch& scratch)
      : s(search),
        line(scratch.line()),
        left_new(scratch.bytes(0)),
        left_old(scratch.bytes(1)),
        right_new(scratch.bytes(2)),
        right_old(scratch.bytes(3)),
        columns(scratch.bytes(20)),
        all(reinterpret_cast<uint16_t*>(scratch.bytes(4))),
        best(reinterpret_cast<int16_t*>(scratch.bytes(8))),
        where(reinterpret_cast<int16_t*>(scratch.bytes(12))),
        places(search.left.width - search.disparities + 1) {}
  uint8_t* column(int d) const { return columns + static_cast<size_t>(d) * line; }
};

/// Brings the sums over the window's rows on by one row; without `subtract` the window is still growing.
template <bool subtract>
void add_row(const Band& b, int y_new, int y_old) {
  const D8 d8;
  const D16 d16;
  const int lanes = static_cast<int>(hn::Lanes(d8)), last = b.s.disparities - 1;
  const size_t width = static_cast<size_t>(b.s.left.width);
  std::memcpy(b.left_new, b.s.left.row(y_new), width);
  std::memcpy(b.right_new, b.s.right.row(y_new), width);
  if constexpr (subtract) {
    std::memcpy(b.left_old, b.s.left.row(y_old), width);
    std::memcpy(b.right_old, b.s.right.row(y_old), width);
  }
  const auto low = hn::Set(d16, uint16_t{255});
  for (int i = 0; i < b.places; i += lanes) {
    const auto here = hn::LoadU(d8, b.left_new + last + i), gone = hn::LoadU(d8, b.left_old + last + i);
    auto even = hn::Zero(d16), odd = even;
    for (int d = 0; d <= last; ++d) {
      uint8_t* column = b.column(d) + i;
      auto sum = hn::Load(d8, column);
      sum = hn::Add(sum, hn::PopulationCount(hn::Xor(here, hn::LoadU(d8, b.right_new + last - d + i))));
      if constexpr (subtract) sum = hn::Sub(sum, hn::PopulationCount(hn::Xor(gone, hn::LoadU(d8, b.right_old + last - d + i))));
      hn::Store(sum, d8, column);
      const auto words = hn::BitCast(d16, sum);
      even = hn::Add(even, hn::And(words, low));
      odd = hn::Add(odd, hn::ShiftRight<8>(words));
    }
    hn::StoreInterleaved2(even, odd, d16, b.all + i);
  }
}

/// Columns whose sums fit a byte together.
constexpr int fitting(int window) { return window == 0 ? 1 : std::min(255 / (8 * window), window); }

/// The cheapest shift of each pixel. `known`: the window, or 0 for any.
template <int known>
void choose_row(const Band& b) {
  const D8 d8;
  const D16 d16;
  const S16 s16;
  constexpr int group = fitting(known);
  const int lanes = static_cast<int>(hn::Lanes(d8)), window = known ? known : b.s.window, pixels = b.places - window + 1;
  const auto low = hn::Set(d16, uint16_t{255});
  for (int i = 0; i < pixels; i += lanes) {
    auto best_even = hn::Set(s16, INT16_MAX), best_odd = best_even, where_even = hn::Zero(s16), where_odd = where_even;
    for (int d = 0; d < b.s.disparities; ++d) {
      const uint8_t* column = b.column(d) + i;
      auto even = hn::Zero(d16), odd = even;
      const auto add = [&](int from, int to) HWY_ATTR {
        auto sum = hn::LoadU(d8, column + from);
        for (int k = from + 1; k < to; ++k) sum = hn::Add(sum, hn::LoadU(d8, column + k));
        const auto words = hn::BitCast(d16, sum);
        even = hn::Add(even, hn::And(words, low));
        odd = hn::Add(odd, hn::ShiftRight<8>(words));
      };
      if constexpr (known != 0) {
        for (int k = 0; k < known; k += group) add(k, std::min(k + group, known));
      } else {
        for (int k = 0; k < window; ++k) add(k, k + 1);
      }
      const auto now = hn::Set(s16, static_cast<int16_t>(d));
      const auto take = [&](auto cost, auto& best, auto& where) HWY_ATTR {
        where = hn::IfThenElse(hn::Lt(cost, best), now, where);
        best = hn::Min(best, cost);
      };
      take(hn::BitCast(s16, even), best_even, where_even);
      take(hn::BitCast(s16, odd), best_odd, where_odd);
    }
    hn::StoreInterleaved2(best_even, best_odd, s16, b.best + i);
    hn::StoreInterleaved2(where_even, where_odd, s16, b.where + i);
  }
}

/// The confidence test: what all shifts cost against the best one. Writes the row's disparities over `where`.
void judge_row(const Band& b) {
  const hn::ScalableTag<int32_t> d32;
  const hn::Rebind<uint16_t, decltype(d32)> u16;
  const hn::Rebind<int16_t, decltype(d32)> s16;
  const int lanes = static_cast<int>(hn::Lanes(d32)), pixels = b.places - b.s.window + 1;
  const auto count = hn::Set(d32, b.s.disparities), least = hn::Set(d32, b.s.confidence), refused = hn::Set(d32, int32_t{b.s.refused});
  for (int i = 0; i < pixels; i += lanes) {
    auto all = hn::PromoteTo(d32, hn::LoadU(u16, b.all + i));
    for (int k = 1; k < b.s.window; ++k) all = hn::Add(all, hn::PromoteTo(d32, hn::LoadU(u16, b.all + i + k)));
    const auto best = hn::PromoteTo(d32, hn::LoadU(s16, b.best + i)), where = hn::PromoteTo(d32, hn::LoadU(s16, b.where + i));
    const auto clear = hn::Sub(all, hn::Mul(best, count));
    hn::StoreU(hn::DemoteTo(s16, hn::IfThenElse(hn::Lt(clear, least), refused, hn::ShiftLeft<4>(where))), s16, b.where + i);
  }
}

void match_hamming(const HammingSearch& s, int first, int last, HammingScratch& scratch, Plane<int16_t> out) {
  const int r = s.window / 2, from = std::max(first, r), to = std::min(last, s.left.height - r);
  const Band band(s, scratch);
  for (int y = first; y < last; ++y) std::fill_n(out.row(y), out.width, s.outside);
  if (from >= to || s.last_column() <= s.first_column()) return;
  std::memset(band.columns, 0, static_cast<size_t>(s.disparities) * band.line);
  for (int y = from - r; y < from + r; ++y) add_row<false>(band, y, y);
  for (int y = from; y < to; ++y) {
    y == from ? add_row<false>(band, y + r, y + r) : add_row<true>(band, y + r, y - r - 1);
    switch (s.window) {
      case 5: choose_row<5>(band); break;
      case 7: choose_row<7>(band); break;
      case 9: choose_row<9>(band); break;
      case 11: choose_row<11>(band); break;
      case 13: choose_row<13>(band); break;
      case 15: choose_row<15>(band); break;
      default: choose_row<0>(band);
    }
    judge_row(band);
    std::copy_n(band.where, s.last_column() - s.first_column(), out.row(y) + s.first_column());
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(match_hamming);
void choose_hamming(Kernels& table) { table.match_hamming = VDISP_CHOSEN(match_hamming); }
}  // namespace vdisp::kernels
#endif
