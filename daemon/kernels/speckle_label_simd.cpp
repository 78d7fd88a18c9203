// speckle_label_simd.cpp: the regions of the speckle filter for all instruction sets: compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <utility>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/speckle_label_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void speckle_label(Plane<const int16_t> in, const SpeckleRule& rule, int first, int last, SpeckleScratch& scratch) {
  plain::speckle_label(in, rule, first, last, scratch);
}
#else

// Time goes into branches: on real images half of the runs are one or two pixels long, and a quarter touch two runs above. So vectors
// make bit masks, masks make lists of positions, and the lists are worked through without a question about what they hold.

/// What is known of a row, in words of 64 pixels.
struct RowBits {
  uint64_t *left, *starts;  // joined to the left; first of a run
  uint64_t* runs;           // index of the first run that starts in a word

  /// Index of the run at column x.
  HWY_INLINE int32_t run(int x) const {
    const uint64_t up_to_x = ~uint64_t{0} >> (63 - x % 64);
    return static_cast<int32_t>(runs[x / 64] + hwy::PopCount(starts[x / 64] & up_to_x)) - 1;
  }
};

/// Where a pixel has no disparity, and where it is too far from its left and from its upper neighbour.
struct Far {
  uint64_t *none, *left, *above;
};

/// Writes lanes / 8 bytes of each mask, from `byte` on.
template <class D>
HWY_INLINE void compare(D d, const SpeckleRule& rule, const int16_t* here, const int16_t* left, const int16_t* above, int byte,
                        const Far& far) {
  // |a - b| <= m is 0 <= a - b + m <= 2 m; moved down by 32768, so that one signed comparison does for both ends.
  const auto shift = hn::Set(d, static_cast<int16_t>(rule.max_difference - 32768));
  const auto most = hn::Set(d, static_cast<int16_t>(2 * rule.max_difference - 32768));
  const auto a = hn::LoadU(d, here);
  const auto moved = hn::Add(a, shift);
  const auto store = [&](auto mask, uint64_t* to) { hn::StoreMaskBits(d, mask, reinterpret_cast<uint8_t*>(to) + byte); };
  store(hn::Lt(a, hn::Set(d, rule.least)), far.none);
  store(hn::Gt(hn::Sub(moved, hn::LoadU(d, left)), most), far.left);
  store(hn::Gt(hn::Sub(moved, hn::LoadU(d, above)), most), far.above);
}

/// The masks of one row. What they say of the left of column 0 and of columns beyond the width means nothing.
HWY_NOINLINE void compare_row(const SpeckleRule& rule, const int16_t* here, const int16_t* above, int width, const Far& far) {
  const hn::CappedTag<int16_t, 64> d;
  const int lanes = static_cast<int>(hn::Lanes(d)), whole = width / lanes * lanes;
  int16_t edge[3][64 + 1];
  // The first pixel has no left neighbour, the last ones no vector of their own.
  if (whole > 0) {
    edge[0][0] = 0;
    hn::StoreU(hn::LoadU(d, here), d, edge[0] + 1);
    compare(d, rule, here, edge[0], above, 0, far);
  }
  for (int x = lanes; x < whole; x += lanes) compare(d, rule, here + x, here + x - 1, above + x, x / 8, far);
  if (whole == width) return;
  for (int i = 0; i < lanes; ++i) {
    const int x = std::min(whole + i, width - 1);
    edge[0][i] = here[x];
    edge[1][i] = here[std::max(x - 1, 0)];
    edge[2][i] = above[x];
  }
  compare(d, rule, edge[0], edge[1], edge[2], whole / 8, far);
}

/// Writes the positions of the bits, counted from x, and up to 63 numbers more; returns how many there are.
HWY_INLINE int32_t list_bits(uint64_t bits, int x, uint16_t* to) {
  const int32_t count = static_cast<int32_t>(hwy::PopCount(bits));
#if HWY_TARGET == HWY_AVX3_DL
  const hn::FixedTag<uint16_t, 32> d;
  uint8_t bytes[8];
  memcpy(bytes, &bits, sizeof(bits));
  const auto low = hn::Iota(d, static_cast<uint16_t>(x));
  hn::StoreU(hn::CompressBits(low, bytes), d, to);
  hn::StoreU(hn::CompressBits(hn::Add(low, hn::Set(d, 32)), bytes + 4), d, to + hwy::PopCount(bits & 0xFFFFFFFF));
#else
  for (int32_t i = 0; i < count; i += 4) {
    for (int k = 0; k < 4; ++k) {
      to[i + k] = static_cast<uint16_t>(x + static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero64(bits | uint64_t{1} << 63)));
      bits &= bits - 1;
    }
  }
#endif
  return count;
}

/// The runs of a row, from `run` on, each a tree of its own; returns the end of their indices.
HWY_NOINLINE int32_t list_runs(const Far& far, int width, int32_t run, const RowBits& here, SpeckleScratch& s) {
  const int words = (width + 63) / 64;
  const int32_t first = run;
  int32_t ended = run;
  uint64_t carry = 0;
  for (int w = 0; w < words; ++w) {
    uint64_t valid = ~far.none[w];
    if (w == words - 1) valid &= ~uint64_t{0} >> (64 * words - width);
    const uint64_t after_valid = valid << 1 | carry;
    const uint64_t left = ~far.left[w] & valid & after_valid;
    carry = valid >> 63;
    here.left[w] = left;
    here.starts[w] = valid & ~left;
    here.runs[w] = static_cast<uint64_t>(run);
    run += list_bits(valid & ~left, 64 * w, s.begin.get() + run);
    ended += list_bits(after_valid & ~left, 64 * w, s.end.get() + ended);
  }
  if (carry) s.end[ended] = static_cast<uint16_t>(width);
  for (int32_t i = first; i < run; ++i) s.parent[i] = i;
  return run;
}

/// Where two runs, one above the other, are joined: one position for each two.
HWY_NOINLINE int32_t list_crossings(const uint64_t* far, int words, const RowBits& here, const RowBits& above, uint16_t* to) {
  int32_t count = 0;
  uint64_t carry = 0;
  for (int w = 0; w < words; ++w) {
    const uint64_t joined = ~far[w] & (here.left[w] | here.starts[w]) & (above.left[w] | above.starts[w]);
    const uint64_t same_two = here.left[w] & above.left[w] & (joined << 1 | carry);
    count += list_bits(joined & ~same_two, 64 * w, to + count);
    carry = joined >> 63;
  }
  return count;
}

HWY_INLINE int32_t find(int32_t* parent, int32_t run) {
  while (parent[run] != run) run = parent[run] = parent[parent[run]];
  return run;
}

/// Joins the runs of a row with the trees above. A run takes the parent of the run at its last crossing: nothing to look up, since it is
/// still a tree of its own. For each crossing before the last, two runs above become one tree; these pairs are fewer than the runs above,
/// and wait in those runs' places in `area`, which nobody needs before the end.
HWY_NOINLINE void join_above(const uint16_t* crossings, int32_t count, const RowBits& here, const RowBits& above, int32_t first_above,
                             SpeckleScratch& s) {
  int32_t* parent = s.parent.get();
  int32_t* pairs = s.area.get() + first_above;
  int32_t pair_count = 0, last_run = -1, last_other = 0;
  for (int32_t i = 0; i < count; ++i) {
    const int32_t run = here.run(crossings[i]), other = above.run(crossings[i]);
    parent[run] = parent[other];
    pairs[pair_count] = (last_other - first_above) << 16 | (other - first_above);
    pair_count += run == last_run;
    last_run = run;
    last_other = other;
  }
  for (int32_t i = 0; i < pair_count; ++i) {
    const int32_t a = find(parent, first_above + static_cast<int32_t>(static_cast<uint32_t>(pairs[i]) >> 16));
    const int32_t b = find(parent, first_above + (pairs[i] & 0xFFFF));
    parent[std::max(a, b)] = std::min(a, b);
  }
}

/// Hangs each run below its root, where the pixels are counted.
HWY_NOINLINE void flatten(int32_t run, int32_t last, SpeckleScratch& s) {
  for (; run < last; ++run) {
    const int32_t root = s.parent[s.parent[run]];
    s.parent[run] = root;
    s.area[run] = 0;
    s.area[root] += s.end[run] - s.begin[run];
  }
}

void speckle_label(Plane<const int16_t> in, const SpeckleRule& rule, int first, int last, SpeckleScratch& s) {
  const int words = (in.width + 63) / 64;
  uint64_t* masks = s.masks(first);
  const auto next = [&] { return std::exchange(masks, masks + s.words); };
  RowBits here{next(), next(), next()}, above{next(), next(), next()};
  const Far far_above{next(), nullptr, next()};
  uint16_t* crossings = s.crossings.get() + s.first_run(first);
  int32_t run = s.first_run(first);
  for (int y = first; y < last; ++y) {
    const Far far{far_above.none, here.left, far_above.above};
    compare_row(rule, in.row(y), in.row(std::max(y - 1, first)), in.width, far);
    s.rows[y] = {run, list_runs(far, in.width, run, here, s), y == first};
    run = s.rows[y].last;
    if (y > first) {
      const int32_t count = list_crossings(far.above, words, here, above, crossings);
      join_above(crossings, count, here, above, s.rows[y - 1].first, s);
    }
    std::swap(here, above);
  }
  flatten(s.first_run(first), run, s);
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(speckle_label);
void choose_speckle_label(Kernels& table) { table.speckle_label = VDISP_CHOSEN(speckle_label); }
}  // namespace vdisp::kernels
#endif
