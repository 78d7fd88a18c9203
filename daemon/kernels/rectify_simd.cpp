// rectify_simd.cpp: rectification for all instruction sets: each block's window is loaded once and its pixels picked by byte shuffles.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/rectify_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void rectify(const RectifyTable& table, View8 in, int first, int last, Plane<uint8_t> out) { plain::rectify(table, in, first, last, out); }
#else

constexpr int block = RectifyTable::block, window = RectifyTable::window;
// Vectors of two windows pay on x86, where the second is loaded into its half at no cost of its own. Not four: that costs.
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
using Bytes = hn::CappedTag<uint8_t, 2 * window>;
#else
using Bytes = hn::CappedTag<uint8_t, window>;
#endif
using Words = hn::Repartition<int16_t, Bytes>;
using Vec = hn::Vec<Bytes>;
using Vec16 = hn::Vec<Words>;
constexpr int windows = static_cast<int>(hn::MaxLanes(Bytes())) / window;

/// First byte of each pair times the first byte of its weights, plus second times second.
HWY_INLINE Vec16 weigh(Vec pairs, Vec weights) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  return Vec16{_mm256_maddubs_epi16(pairs.raw, weights.raw)};
#elif HWY_ARCH_X86
  return Vec16{_mm_maddubs_epi16(pairs.raw, weights.raw)};
#else
  const Words d16;
  const hn::RebindToUnsigned<Words> du16;
  const auto low = hn::Set(du16, 255), p = hn::BitCast(du16, pairs), w = hn::BitCast(du16, weights);
  return hn::BitCast(d16, hn::Add(hn::Mul(hn::And(p, low), hn::And(w, low)), hn::Mul(hn::ShiftRight<8>(p), hn::ShiftRight<8>(w))));
#endif
}

/// The first block of a, numbers of 0 .. 255, as bytes.
HWY_INLINE void store_block(Vec16 a, uint8_t* to) {
  const hn::CappedTag<int16_t, block> one;
  const hn::Rebind<uint8_t, decltype(one)> eight;
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  hn::StoreU(hn::DemoteTo(eight, hn::LowerHalf(a)), eight, to);
#else
  hn::StoreU(hn::DemoteTo(eight, a), eight, to);
#endif
}

/// The first block of a, the first of b, the second of a, and so on.
HWY_INLINE void store_group(Vec16 a, Vec16 b, uint8_t* to) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  hn::StoreU(Vec{_mm256_packus_epi16(a.raw, b.raw)}, Bytes(), to);
#elif HWY_ARCH_X86
  hn::StoreU(Vec{_mm_packus_epi16(a.raw, b.raw)}, Bytes(), to);
#else
  // Not ConcatEven: Highway 1.0.3 has it wrong for part of a vector on SVE of 256 bits.
  store_block(a, to);
  store_block(b, to + block);
#endif
}

/// The contract's formula.
HWY_INLINE Vec16 blended(Vec above, Vec below, Vec weights, Vec part_y) {
  const Words d16;
  const auto top = weigh(above, weights), bottom = weigh(below, weights);
  const auto down = hn::MulFixedPoint15(hn::Sub(bottom, top), hn::BitCast(d16, part_y));
  return hn::MulFixedPoint15(hn::Add(top, down), hn::Set(d16, 1024));
}

/// 16 bytes from there, and as many from the other.
HWY_INLINE Vec side_by_side(const uint8_t* one, [[maybe_unused]] const uint8_t* other) {
  const Bytes d8;
  if constexpr (windows == 1) {
    return hn::LoadU(d8, one);
  } else {
    const hn::Half<Bytes> half;
    return hn::Combine(d8, hn::LoadU(half, other), hn::LoadU(half, one));
  }
}

/// A row of the table, and the raw image.
struct Row {
  const int32_t* places;
  const uint16_t* patterns;
  const RectifyTable::Pattern* pattern;
  const uint8_t *parts_x, *parts_y;
  View8 in;

  const RectifyTable::Pattern& pattern_of(int b) const { return pattern[patterns[b]]; }
};

/// The block's or blocks' pixels, from the rows of their windows and the columns to be picked from each.
template <int rows, class Window, class Picks>
HWY_INLINE Vec16 picked(Window window_row, Picks picks, Vec weights, Vec part_y) {
  auto above = hn::Zero(Bytes()), below = above, next = window_row(0);
  HWY_UNROLL(4)
  for (int row = 0; row < rows; ++row) {
    const auto here = next, pick = picks(row);
    next = window_row(row + 1);
    above = hn::Or(above, hn::TableLookupBytesOr0(here, pick));
    below = hn::Or(below, hn::TableLookupBytesOr0(next, pick));
  }
  return blended(above, below, weights, part_y);
}

/// Block b and, where a vector has two windows, the other one: both inside.
template <int rows>
HWY_INLINE Vec16 inside_blocks(const Row& r, int b, int other, Vec weights, Vec part_y) {
  const uint8_t *one = r.in.data + r.places[b], *two = r.in.data + r.places[other];
  const RectifyTable::Pattern &pick_one = r.pattern_of(b), &pick_two = r.pattern_of(other);
  const auto first_picks = side_by_side(pick_one.in_row[0], pick_two.in_row[0]);
  const auto window_row = [&](int row) HWY_ATTR { return side_by_side(one + row * r.in.stride, two + row * r.in.stride); };
  const auto picks = [&](int row) HWY_ATTR {
    if (row == 0) return first_picks;
    // Of two rows a pixel is in one or the other.
    if (rows == 2) return hn::Xor(first_picks, hn::Set(Bytes(), 0x80));
    return side_by_side(pick_one.in_row[row], pick_two.in_row[row]);
  };
  return picked<rows>(window_row, picks, weights, part_y);
}

/// From block b on, as many at once as fill a vector with pixels, up to the first group with a block that is not inside. Returns where
/// it ended. Apart from all calls, so that what does not change stays in registers.
template <int rows>
HWY_NOINLINE int inside_run(const Row r, int b, int end, uint8_t* to) {
  const Bytes d8;
  constexpr int group = 2 * windows, next = 2 * (windows - 1);
  for (; b + group <= end; b += group) {
    int32_t all = 0;
    for (int i = b; i < b + group; ++i) all |= r.places[i];
    if (all < 0) break;
    const auto part_x = hn::Load(d8, r.parts_x + b * block), part_y = hn::Load(d8, r.parts_y + b * block);
    const auto rest_x = hn::Sub(hn::Set(d8, 32), part_x), zero = hn::Zero(d8);
    const auto first = inside_blocks<rows>(r, b, b + next, hn::InterleaveLower(d8, rest_x, part_x), hn::InterleaveLower(d8, zero, part_y));
    const auto second =
        inside_blocks<rows>(r, b + 1, b + 1 + next, hn::InterleaveUpper(d8, rest_x, part_x), hn::InterleaveUpper(d8, zero, part_y));
    store_group(first, second, to + b * block);
  }
  return b;
}

/// A row of a window, 0 where outside the image, in every 16 bytes.
HWY_INLINE Vec border_row(View8 in, int column, int row) {
  const Bytes d8;
  if (row < 0 || row >= in.height) return hn::Zero(d8);
  const int from = std::clamp(column, 0, in.width - window);
  const auto there = hn::LoadDup128(d8, in.row(row) + from);
  // Columns before the first become numbers above 240.
  const auto at = hn::Add(hn::And(hn::Iota(d8, 0), hn::Set(d8, 15)), hn::Set(d8, static_cast<uint8_t>(column - from)));
  return hn::TableLookupBytesOr0(there, hn::Or(at, hn::VecFromMask(d8, hn::Gt(at, hn::Set(d8, 15)))));
}

/// One block that has a window.
template <int rows>
HWY_INLINE Vec16 window_block(const RectifyTable& table, const Row& r, int b) {
  const Bytes d8;
  const auto part_x = hn::LoadU(d8, r.parts_x + b * block);
  const auto part_y = hn::InterleaveLower(d8, hn::Zero(d8), hn::LoadU(d8, r.parts_y + b * block));
  const auto weights = hn::InterleaveLower(d8, hn::Sub(hn::Set(d8, 32), part_x), part_x);
  if (r.places[b] >= 0) return inside_blocks<rows>(r, b, b, weights, part_y);
  const RectifyTable::Special& s = table.special(r.places[b]);
  const RectifyTable::Pattern& pick = r.pattern_of(b);
  const auto window_row = [&](int row) HWY_ATTR { return border_row(r.in, s.column, s.row + row); };
  const auto picks = [&](int row) HWY_ATTR { return hn::LoadDup128(d8, pick.in_row[row]); };
  return picked<RectifyTable::most_rows>(window_row, picks, weights, part_y);
}

/// One block of any kind: eight pixels at `to`.
template <int rows>
HWY_NOINLINE void any_block(const RectifyTable& table, const Row& r, int b, uint8_t* to) {
  const int32_t place = r.places[b];
  if (place == RectifyTable::nowhere) {
    std::memset(to, 0, block);
  } else if (place < 0 && table.special(place).kind == RectifyTable::Kind::scattered) {
    for (const RectifyTable::Source& source : table.scattered(table.special(place))) *to++ = plain::rectified(r.in, source);
  } else {
    store_block(window_block<rows>(table, r, b), to);
  }
}

template <int rows>
HWY_INLINE void rectify_row(const RectifyTable& table, View8 in, int y, Plane<uint8_t> out) {
  const Row r{table.places(y), table.patterns(y), table.pattern(), table.parts_x(y), table.parts_y(y), in};
  const int whole = out.width / block, rest = out.width % block;
  uint8_t* to = out.row(y);
  for (int b = 0; b < whole;) {
    b = inside_run<rows>(r, b, whole, to);
    const int from = b;
    while (b < whole && r.places[b] == RectifyTable::nowhere) ++b;
    std::memset(to + from * block, 0, static_cast<size_t>((b - from) * block));
    // Up to where whole vectors begin.
    for (bool more = b < whole; more; more = b < whole && b % (2 * windows)) {
      any_block<rows>(table, r, b, to + b * block);
      ++b;
    }
  }
  if (rest == 0) return;
  uint8_t last[block];
  any_block<rows>(table, r, whole, last);
  std::memcpy(to + whole * block, last, static_cast<size_t>(rest));
}

void rectify(const RectifyTable& table, View8 in, int first, int last, Plane<uint8_t> out) {
  for (int y = first; y < last; ++y) {
    if (table.rows(y) == 2) {
      rectify_row<2>(table, in, y, out);
    } else {
      rectify_row<RectifyTable::most_rows>(table, in, y, out);
    }
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(rectify);
void choose_rectify(Kernels& table) { table.rectify = VDISP_CHOSEN(rectify); }
}  // namespace vdisp::kernels
#endif
