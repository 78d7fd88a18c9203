// map_simd.cpp: obstacle pixels and their cells, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/above.h"
#include "daemon/kernels/ground_rows.h"
#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/map_simd.cpp"
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
void mark_above(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, Plane<uint8_t> mask) {
  plain::mark_above(disparity, search, limit, mask);
}
void count_cells(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, const Ground& ground, Plane<int16_t> map,
                 GroundScratch& scratch) {
  plain::count_cells(disparity, search, limit, ground, map, scratch);
}
#else

void mark_above(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, Plane<uint8_t> mask) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16)), width = disparity.width;
  Above above(search, limit);
  if (!above.solid() || width < lanes) return plain::mark_above(disparity, search, limit, mask);
  const auto set = hn::Set(d16, int16_t{255});
  for (int v = 0; v < disparity.height; ++v) {
    above.go_to(v);
    const auto before = hn::Set(d16, static_cast<int16_t>(above.first - 1)), end = hn::Set(d16, static_cast<int16_t>(above.end));
    const int16_t* from = disparity.row(v);
    uint8_t* to = mask.row(v);
    const auto step = [&](int u) HWY_ATTR {
      const auto d = hn::LoadU(d16, from + u);
      hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(hn::And(hn::Gt(d, before), hn::Lt(d, end)), set)), d8, to + u);
    };
    for (int u = 0; u + lanes <= width; u += lanes) step(u);
    step(width - lanes);
  }
}

/// Cells are counted without a look at the largest count, until it could be too large.
class Counting {
 public:
  explicit Counting(Plane<int16_t> map) : map_(map), counts_(reinterpret_cast<uint16_t*>(map.data)) {}
  ~Counting() {
    if (most_ > INT16_MAX) saturate();
  }
  Counting(const Counting&) = delete;
  Counting& operator=(const Counting&) = delete;

  void add(const int32_t* cells, int n) {
    for (int from = 0; from < n; from += INT16_MAX) add_few(cells + from, std::min(n - from, INT16_MAX));
  }

 private:
  void add_few(const int32_t* cells, int n) {
    if (most_ + n > UINT16_MAX) saturate();
    most_ += n;
    // Neighbours stand in one cell. Taken from eight places of the row, few additions have to wait for the last one to the same cell.
    const int part = n / 8;
    for (int i = 0; i < part; ++i)
      for (int k = 0; k < 8; ++k) ++counts_[cells[k * part + i]];
    for (int i = 8 * part; i < n; ++i) ++counts_[cells[i]];
  }
  void saturate() {
    for (int y = 0; y < map_.height; ++y)
      for (int x = 0; x < map_.width; ++x) {
        uint16_t& count = counts_[y * map_.stride + x];
        count = std::min<uint16_t>(count, INT16_MAX);
      }
    most_ = INT16_MAX;
  }

  Plane<int16_t> map_;
  uint16_t* counts_;
  int most_ = 0;  // no cell has more
};

/// Cells of the pixels of one row with disparities in [first, end). What lies too near to a border for single precision goes to
/// `doubtful`, as columns of the image. Both are numbers of elements when it returns.
class RowCells {
 public:
  RowCells(const Ground& ground, const Search& search, const GroundRows& rows, int stride, GroundScratch& scratch)
      : ground_(ground), search_(search), rows_(rows), stride_(stride), scratch_(scratch) {}

  int cells = 0, doubtful = 0;

  template <class D32>
  HWY_INLINE void step(D32 d32, const int16_t* row, int u, int first, int end) {
    const hn::RebindToFloat<D32> df;
    const hn::Rebind<int16_t, D32> d16;
    const hn::RebindToUnsigned<D32> du32;
    const auto d = hn::PromoteTo(d32, hn::LoadU(d16, row + u));
    const auto usable = hn::Min(hn::Max(d, hn::Set(d32, first)), hn::Set(d32, end - 1));
    const auto asked = hn::Eq(d, usable);
    if (hn::AllFalse(d32, asked)) return;
    const auto z = hn::GatherIndex(df, scratch_.depth.data(), hn::Sub(usable, hn::Set(d32, search_.first)));
    // Both in cells, less half a cell: so the nearest whole number is the cell, and no farther off than half less the margin.
    const auto ahead = hn::Sub(hn::Mul(z, hn::Sub(hn::Set(df, rows_.keep), hn::LoadU(df, scratch_.drop.data() + u))), hn::Set(df, 0.5f));
    const auto right = hn::Mul(z, hn::Sub(hn::LoadU(df, scratch_.across.data() + u), hn::Set(df, rows_.shift)));
    const auto side = hn::Add(right, hn::Set(df, rows_.middle));
    const auto down = hn::NearestInt(ahead), left = hn::NearestInt(side);
    const auto off_ahead = hn::Abs(hn::Sub(ahead, hn::ConvertTo(df, down))), off_side = hn::Abs(hn::Sub(side, hn::ConvertTo(df, left)));
    const auto allowed = hn::Sub(hn::Set(df, rows_.allowed), hn::Mul(z, hn::Set(df, rows_.less_by_depth)));
    const auto sure = hn::RebindMask(d32, hn::Le(hn::Max(off_ahead, off_side), allowed));

    const auto below = [&](auto value, int size) HWY_ATTR {
      return hn::RebindMask(d32, hn::Lt(hn::BitCast(du32, value), hn::Set(du32, static_cast<uint32_t>(size))));
    };
    const auto inside = hn::And(asked, hn::And(below(down, ground_.rows), below(left, ground_.columns)));
    const auto cell = hn::Add(hn::Mul(hn::Sub(hn::Set(d32, ground_.rows - 1), down), hn::Set(d32, stride_)), left);
    cells += static_cast<int>(append(d32, cell, hn::And(inside, sure), scratch_.cells.data() + cells));
    const auto unsure = hn::AndNot(sure, asked);
    if (!hn::AllFalse(d32, unsure))
      doubtful += static_cast<int>(append(d32, hn::Iota(d32, u), unsure, scratch_.doubtful.data() + doubtful));
  }

 private:
  const Ground& ground_;
  const Search& search_;
  const GroundRows& rows_;
  int stride_;
  GroundScratch& scratch_;
};

void count_cells(Plane<const int16_t> disparity, const Search& search, const int16_t* limit, const Ground& ground, Plane<int16_t> map,
                 GroundScratch& scratch) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Repartition<int32_t, decltype(d16)> d32;
  const hn::CappedTag<int32_t, 1> one;
  const int lanes = static_cast<int>(hn::Lanes(d16)), half = static_cast<int>(hn::Lanes(d32)), stride = static_cast<int>(map.stride);
  Above above(search, limit);
  if (!above.solid()) return plain::count_cells(disparity, search, limit, ground, map, scratch);
  GroundRows rows(ground, search, disparity.width, scratch);
  Counting counting(map);
  for (int v = 0; v < disparity.height; ++v) {
    above.go_to(v);
    if (above.first >= above.end) continue;
    rows.go_to(v);
    const int first = std::max(above.first, rows.nearest), end = above.end;
    if (first >= end) continue;
    const int16_t* row = disparity.row(v);
    const auto before = hn::Set(d16, static_cast<int16_t>(first - 1)), past = hn::Set(d16, static_cast<int16_t>(end));
    RowCells found(ground, search, rows, stride, scratch);
    int u = 0;
    const auto inside = [&](int at) HWY_ATTR {
      const auto d = hn::LoadU(d16, row + at);
      return hn::And(hn::Gt(d, before), hn::Lt(d, past));
    };
    for (; u + 2 * lanes <= disparity.width; u += 2 * lanes) {
      if (hn::AllFalse(d16, hn::Or(inside(u), inside(u + lanes)))) continue;
      for (int part = u; part < u + 2 * lanes; part += half) found.step(d32, row, part, first, end);
    }
    for (; u + half <= disparity.width; u += half) found.step(d32, row, u, first, end);
    for (; u < disparity.width; ++u) found.step(one, row, u, first, end);
    for (int i = 0; i < found.doubtful; ++i) {
      const int at = scratch.doubtful[static_cast<size_t>(i)], cell = ground.cell_of(at, v, row[at], stride);
      if (cell >= 0) scratch.cells[static_cast<size_t>(found.cells++)] = cell;
    }
    counting.add(scratch.cells.data(), found.cells);
  }
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(mark_above);
HWY_EXPORT(count_cells);
void choose_map(Kernels& table) {
  table.mark_above = VDISP_CHOSEN(mark_above);
  table.count_cells = VDISP_CHOSEN(count_cells);
}
}  // namespace vdisp::kernels
#endif
