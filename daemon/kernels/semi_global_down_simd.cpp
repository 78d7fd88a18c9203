// semi_global_down_simd.cpp: the paths down and up, and the diagonals, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <utility>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/semi_global_down_simd.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void paths_down(const SemiGlobal& s, int first_block, int last_block, int first_row, int last_row, bool up,
                const SemiGlobalVolume& volume) {
  plain::paths_down(s, first_block, last_block, first_row, last_row, up, volume);
}
#else

constexpr int block = SemiGlobalVolume::block;

/// The columns of some blocks, and what one call works with. Rows of bytes begin 64 before the first column.
struct Work {
  Work(const SemiGlobal& search, int first_block, int last_block, uint8_t* memory)
      : s(search),
        n(search.disparities),
        first(first_block * block),
        columns(std::clamp(search.columns() - first, 0, (last_block - first_block) * block)),
        width((columns + block - 1) / block * block),
        stride(width + 128),
        count(search.paths == 8 ? 6 : 1) {
    const auto take = [&memory](ptrdiff_t bytes) { return std::exchange(memory, memory + bytes); };
    for (int i = 0; i < count; ++i) {
      states[i] = take(stride * n) + 64;
      least[i] = take(stride) + 64;
    }
  }
  /// Nothing has come along any path.
  void begin() const {
    for (int i = 0; i < count; ++i) std::memset(states[i] - 64, 0, static_cast<size_t>(stride * (n + 1)));
  }

  const SemiGlobal& s;
  int n, first, columns, width;
  ptrdiff_t stride;
  int count;
  uint8_t *states[6], *least[6];  // of each diagonal those of the row before and of this one, by turns
};

/// One step of one path for the columns from x on; `from` is where the pixel before stands in this one's row.
template <bool diagonal, class D, class V>
HWY_INLINE void step(D d, const Work& w, int x, int from, V pixels, V pixels_before, int path, int before, const uint8_t* cost,
                     uint8_t* sum, ptrdiff_t next) {
  const SemiGlobal& s = w.s;
  const auto most = hn::Set(d, uint8_t{255}), small = hn::Set(d, static_cast<uint8_t>(s.small));
  auto grey_step = hn::Or(hn::SaturatedSub(pixels, pixels_before), hn::SaturatedSub(pixels_before, pixels));
  for (int k = 0; k < s.slope; ++k) grey_step = hn::SaturatedAdd(grey_step, grey_step);
  const auto penalty =
      hn::Max(hn::SaturatedSub(hn::Set(d, static_cast<uint8_t>(s.large)), grey_step), hn::Set(d, static_cast<uint8_t>(s.large_least)));
  const auto least = hn::LoadU(d, w.least[before] + from), jump = hn::SaturatedAdd(least, penalty);
  // Columns behind the last are no beginning for a diagonal.
  const auto inside = hn::Lt(hn::Iota(d, 0), hn::Set(d, static_cast<uint8_t>(std::clamp(w.columns - x, 0, block))));
  const uint8_t* old = w.states[before] + from;
  uint8_t* state = w.states[path] + x;
  auto below = most, here = hn::LoadU(d, old), next_least = most;
  for (int i = 0; i < w.n; ++i, old += w.stride, state += w.stride, cost += block, sum += block) {
    hwy::Prefetch(cost + next);
    hwy::Prefetch(sum + next);
    const auto above = i + 1 < w.n ? hn::LoadU(d, old + w.stride) : most;
    auto way = hn::Min(hn::Min(here, jump), hn::SaturatedAdd(hn::Min(below, above), small));
    way = hn::SaturatedAdd(hn::Sub(way, least), hn::LoadU(d, cost));
    if (diagonal) way = hn::IfThenElseZero(inside, way);
    hn::StoreU(way, d, state);
    next_least = hn::Min(next_least, way);
    hn::StoreU(hn::SaturatedAdd(diagonal ? hn::ShiftRight<1>(way) : way, hn::LoadU(d, sum)), d, sum);
    below = here;
    here = above;
  }
  hn::StoreU(next_least, d, w.least[path] + x);
}

/// Pixels of the left view from x on; behind the last column it repeats.
template <class D>
HWY_INLINE hn::Vec<D> pixels_at(D d, const Work& w, int y, int x) {
  const int lanes = static_cast<int>(hn::Lanes(d)), column = w.s.first_column() + w.first + x;
  const uint8_t* row = w.s.image.row(y);
  if (column >= 0 && column + lanes <= w.s.image.width) return hn::LoadU(d, row + column);
  HWY_ALIGN uint8_t pixels[block];
  for (int i = 0; i < lanes; ++i) pixels[i] = row[std::clamp(column + i, 0, w.s.image.width - 1)];
  return hn::LoadU(d, pixels);
}

/// All paths of one row.
template <bool diagonals, class D>
HWY_INLINE void row_of(D d, const Work& w, const SemiGlobalVolume& volume, int y, int before, ptrdiff_t next) {
  const int lanes = static_cast<int>(hn::Lanes(d)), now = y & 1;
  for (int x = 0; x < w.width; x += lanes) {
    const int b = (w.first + x) / block, in_block = x % block;
    const uint8_t* cost = volume.costs(y, b) + in_block;
    uint8_t* sum = volume.sums(y, b) + in_block;
    const auto pixels = pixels_at(d, w, y, x);
    if (diagonals) {
      for (int dx : {-1, 0, 1})
        step<true>(d, w, x, x + dx, pixels, pixels_at(d, w, before, x + dx), 2 * dx + 2 + now, 2 * dx + 3 - now, cost, sum, next);
    } else {
      step<false>(d, w, x, x, pixels, pixels_at(d, w, before, x), 0, 0, cost, sum, next);
    }
  }
}

void paths_down(const SemiGlobal& s, int first_block, int last_block, int first_row, int last_row, bool up,
                const SemiGlobalVolume& volume) {
  const hn::CappedTag<uint8_t, 64> d;
  const Work w(s, first_block, last_block, volume.states(first_block));
  if (w.columns == 0) return;
  if (up ? last_row == s.image.height : first_row == 0) w.begin();
  for (int k = 0; k < last_row - first_row; ++k) {
    const int y = up ? last_row - 1 - k : first_row + k, before = std::clamp(up ? y + 1 : y - 1, 0, s.image.height - 1);
    // Where the next row stands, if it is not held where this one is.
    const ptrdiff_t next = volume.costs(std::clamp(up ? y - 1 : y + 1, 0, s.image.height - 1), 0) - volume.costs(y, 0);
    if (s.paths == 8) {
      row_of<true>(d, w, volume, y, before, next);
    } else {
      row_of<false>(d, w, volume, y, before, next);
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
HWY_EXPORT(paths_down);
void choose_paths_down(Kernels& table) { table.paths_down = VDISP_CHOSEN(paths_down); }
}  // namespace vdisp::kernels
#endif
