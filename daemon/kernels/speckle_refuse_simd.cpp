// speckle_refuse_simd.cpp: the end of the speckle filter for all instruction sets: compiled once for each, by including itself.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <utility>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/speckle_refuse_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void speckle_refuse(const SpeckleRule& rule, int first, int last, SpeckleScratch& scratch, Plane<int16_t> out) {
  plain::speckle_refuse(rule, first, last, scratch, out);
}
#else

/// Bits of those of up to 64 runs that belong to a small region.
HWY_NOINLINE uint64_t small_ones(const SpeckleScratch& s, int32_t run, int32_t last, int max_size) {
  uint64_t bits = 0;
  const int32_t count = std::min(last - run, 64);
  for (int32_t i = 0; i < count; ++i) bits |= static_cast<uint64_t>(s.area[s.parent[run + i]] <= max_size) << i;
  return bits;
}

#if HWY_TARGET <= HWY_AVX3
/// Masked stores: a run is written with one of them, most often.
struct Eraser {
  Eraser(uint64_t* /*masks*/, int /*width*/, int16_t refused) : refused_(refused) {}
  HWY_INLINE void refuse(int from, int to, int16_t* row) const {
    const hn::FixedTag<int16_t, 32> d;
    for (int x = from; x < to; x += 32) hn::BlendedStore(hn::Set(d, refused_), hn::FirstN(d, static_cast<size_t>(to - x)), d, row + x);
  }
  void end_row(int16_t* /*row*/) const {}
  int16_t refused_;
};
#else
/// Runs become bits, and bits pixels once the row is through: to write runs of one or two pixels one by one costs twice that.
struct Eraser {
  Eraser(uint64_t* masks, int width, int16_t refused) : masks_(masks), width_(width), refused_(refused) {
    std::fill_n(masks, (width + 63) / 64 + 1, uint64_t{0});
  }
  HWY_INLINE void refuse(int from, int to, int16_t* /*row*/) const {
    for (; to - from > 64; from += 64) add(from, ~uint64_t{0});
    add(from, ~uint64_t{0} >> (64 - (to - from)));
  }
  HWY_INLINE void add(int from, uint64_t ones) const {
    masks_[from / 64] |= ones << from % 64;
    masks_[from / 64 + 1] |= ones >> 1 >> (63 - from % 64);
  }
  void end_row(int16_t* row) const {
    const hn::CappedTag<int16_t, 64> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    for (int x = 0; x < width_; x += 64) {
      const uint64_t bits = std::exchange(masks_[x / 64], 0);
      if (bits == 0) continue;
      uint8_t bytes[16];
      memcpy(bytes, &bits, sizeof(bits));
      int i = 0;
      for (; i < 64 && x + i + lanes <= width_; i += lanes) {
        int16_t* to = row + x + i;
        hn::StoreU(hn::IfThenElse(hn::LoadMaskBits(d, bytes + i / 8), hn::Set(d, refused_), hn::LoadU(d, to)), d, to);
      }
      for (; i < 64 && x + i < width_; ++i) {
        if (bits >> i & 1) row[x + i] = refused_;
      }
    }
  }
  uint64_t* masks_;
  int width_;
  int16_t refused_;
};
#endif

void speckle_refuse(const SpeckleRule& rule, int first, int last, SpeckleScratch& s, Plane<int16_t> out) {
  const Eraser eraser(s.masks(first), out.width, rule.refused);
  const uint16_t *begin = s.begin.get(), *end = s.end.get();
  for (int y = first; y < last; ++y) {
    int16_t* row = out.row(y);
    const int32_t row_end = s.rows[y].last;
    for (int32_t run = s.rows[y].first; run < row_end; run += 64) {
      for (uint64_t bits = small_ones(s, run, row_end, rule.max_size); bits; bits &= bits - 1) {
        const int32_t i = run + static_cast<int32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero64(bits));
        eraser.refuse(begin[i], end[i], row);
      }
    }
    eraser.end_row(row);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(speckle_refuse);
void choose_speckle_refuse(Kernels& table) { table.speckle_refuse = VDISP_CHOSEN(speckle_refuse); }
}  // namespace vdisp::kernels
#endif
