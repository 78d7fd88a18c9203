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
void paths_down(const SemiGlobal& s, int first_block, int last_block, const SemiGlobalVolume& volume, uint8_t* work) {
  plain::paths_down(s, first_block, last_block, volume, work);
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
        stride(width + 128) {
    const auto take = [&memory](ptrdiff_t bytes) { return std::exchange(memory, memory + bytes); };
    for (uint8_t*& state : states) state = take(stride * n) + 64;
    for (uint8_t*& row : least) row = take(stride) + 64;
    for (uint8_t*& row : pixels) row = take(stride) + 64;
  }
  /// The left view's pixels, with those beside them where there are any.
  void fetch(int y, uint8_t* out) const {
    const int left = first > 0 ? 1 : 0, right = first + columns < s.columns() ? 1 : 0;
    std::memcpy(out - left, s.image.row(y) + s.first_column() + first - left, static_cast<size_t>(columns + left + right));
  }
  /// Nothing has come along any path.
  void begin() const {
    for (uint8_t* state : states) std::memset(state - 64, 0, static_cast<size_t>(stride * n));
    for (uint8_t* row : least) std::memset(row - 64, 0, static_cast<size_t>(stride));
  }

  const SemiGlobal& s;
  int n, first, columns, width;
  ptrdiff_t stride;
  uint8_t *states[6], *least[6], *pixels[2];  // of each path those of the row before and of this one
};

/// One step of one path for the columns from x on; `from` is where the pixel before stands in this one's row.
template <bool diagonal, class D>
HWY_INLINE void step(D d, const Work& w, int x, int from, const uint8_t* pixels, const uint8_t* pixels_before, int path, int before,
                     const uint8_t* cost, uint8_t* sum, ptrdiff_t next) {
  const SemiGlobal& s = w.s;
  const auto most = hn::Set(d, uint8_t{255}), small = hn::Set(d, static_cast<uint8_t>(s.small));
  const auto here_pixel = hn::LoadU(d, pixels + x), there_pixel = hn::LoadU(d, pixels_before + from);
  auto grey_step = hn::Or(hn::SaturatedSub(here_pixel, there_pixel), hn::SaturatedSub(there_pixel, here_pixel));
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

template <bool diagonals, class D>
HWY_INLINE void pass(D d, const Work& w, const SemiGlobalVolume& volume, int dy) {
  const int lanes = static_cast<int>(hn::Lanes(d)), height = w.s.image.height;
  w.begin();
  for (int k = 0; k < height; ++k) {
    const int y = dy < 0 ? k : height - 1 - k, now = k & 1;
    const ptrdiff_t next = k + 1 < height ? -dy * static_cast<ptrdiff_t>(volume.stride()) : 0;
    uint8_t *pixels = w.pixels[now], *pixels_before = w.pixels[1 - now];
    w.fetch(y, pixels);
    if (k == 0) std::memcpy(pixels_before - 64, pixels - 64, static_cast<size_t>(w.stride));
    for (int x = 0; x < w.width; x += lanes) {
      const int b = (w.first + x) / block, in_block = x % block;
      const uint8_t* cost = volume.costs(y, b) + in_block;
      uint8_t* sum = volume.sums(y, b) + in_block;
      if (diagonals) {
        for (int dx : {-1, 0, 1}) step<true>(d, w, x, x + dx, pixels, pixels_before, 2 * dx + 2 + now, 2 * dx + 3 - now, cost, sum, next);
      } else {
        step<false>(d, w, x, x, pixels, pixels_before, 0, 0, cost, sum, next);
      }
    }
  }
}

void paths_down(const SemiGlobal& s, int first_block, int last_block, const SemiGlobalVolume& volume, uint8_t* memory) {
  const hn::CappedTag<uint8_t, 64> d;
  const Work w(s, first_block, last_block, memory);
  if (w.columns == 0) return;
  for (int dy : {-1, 1}) {
    if (s.paths == 8) {
      pass<true>(d, w, volume, dy);
    } else {
      pass<false>(d, w, volume, dy);
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
