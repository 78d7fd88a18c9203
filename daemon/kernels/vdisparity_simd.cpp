// vdisparity_simd.cpp: counting disparities for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/vdisparity_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/append_simd.h"
#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void count_votes(Plane<const int16_t> disparity, int first, int last, const Search& search, Plane<int16_t> votes, uint16_t* scratch) {
  plain::count_votes(disparity, first, last, search, votes, scratch);
}
#else

/// Columns of the pixels that count, one behind the other. What does not count is left out rather than counted somewhere harmless:
/// rejected pixels stand side by side, and adding to one counter again and again waits each time for the last store.
HWY_INLINE int list_columns(const int16_t* row, int width, const Search& search, uint16_t* list) {
  const hn::ScalableTag<int16_t> d16;
  const hn::RebindToUnsigned<decltype(d16)> du16;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto before = hn::Set(d16, static_cast<int16_t>(search.least - 1)), end = hn::Set(d16, static_cast<int16_t>(search.end()));
  const auto origin = hn::Set(d16, static_cast<int16_t>(search.first));
  uint16_t* to = list;
  int u = 0;
  for (; u + lanes <= width; u += lanes) {
    const auto d = hn::LoadU(d16, row + u);
    const auto counts = hn::And(hn::Gt(d, before), hn::Lt(d, end));
    to += append(du16, hn::BitCast(du16, hn::Sub(d, origin)), hn::RebindMask(du16, counts), to);
  }
  for (; u < width; ++u) {
    *to = static_cast<uint16_t>(row[u] - search.first);
    to += search.counts(row[u]);
  }
  return static_cast<int>(to - list);
}

void count_votes(Plane<const int16_t> disparity, int first, int last, const Search& search, Plane<int16_t> votes, uint16_t* scratch) {
  if (disparity.width > INT16_MAX) return plain::count_votes(disparity, first, last, search, votes, scratch);
  uint16_t *l0 = scratch, *l1 = l0 + disparity.width + 128, *l2 = l1 + disparity.width + 128, *l3 = l2 + disparity.width + 128;
  int v = first;
  // Four rows side by side: neighbours in a row often share a counter, four rows never do.
  for (; v + 4 <= last; v += 4) {
    int16_t *v0 = votes.row(v), *v1 = votes.row(v + 1), *v2 = votes.row(v + 2), *v3 = votes.row(v + 3);
    const int n0 = list_columns(disparity.row(v), disparity.width, search, l0);
    const int n1 = list_columns(disparity.row(v + 1), disparity.width, search, l1);
    const int n2 = list_columns(disparity.row(v + 2), disparity.width, search, l2);
    const int n3 = list_columns(disparity.row(v + 3), disparity.width, search, l3);
    for (int16_t* row : {v0, v1, v2, v3}) std::fill_n(row, votes.width, int16_t{0});
    if (v + 8 <= last) {
      for (int next = v + 4; next < v + 8; ++next) {
        for (int i = 0; i < votes.width; i += 32) __builtin_prefetch(votes.row(next) + i);
        for (int i = 0; i < disparity.width; i += 32) __builtin_prefetch(disparity.row(next) + i);
      }
    }
    const int shared = std::min({n0, n1, n2, n3});
    for (int i = 0; i < shared; ++i) {
      ++v0[l0[i]];
      ++v1[l1[i]];
      ++v2[l2[i]];
      ++v3[l3[i]];
    }
    for (int i = shared; i < n0; ++i) ++v0[l0[i]];
    for (int i = shared; i < n1; ++i) ++v1[l1[i]];
    for (int i = shared; i < n2; ++i) ++v2[l2[i]];
    for (int i = shared; i < n3; ++i) ++v3[l3[i]];
  }
  for (; v < last; ++v) {
    int16_t* row = votes.row(v);
    const int n = list_columns(disparity.row(v), disparity.width, search, l0);
    std::fill_n(row, votes.width, int16_t{0});
    const int quarter = n / 4;
    for (int i = 0; i < quarter; ++i)
      for (int part = 0; part < 4; ++part) ++row[l0[part * quarter + i]];
    for (int i = 4 * quarter; i < n; ++i) ++row[l0[i]];
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(count_votes);
void choose_vdisparity(Kernels& table) { table.count_votes = VDISP_CHOSEN(count_votes); }
}  // namespace vdisp::kernels
#endif
