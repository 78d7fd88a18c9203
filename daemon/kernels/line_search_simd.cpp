// line_search_simd.cpp: listing points, and asking which lie near a line, for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/line_search_simd.cpp"
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
size_t collect_points(Plane<const int16_t> votes, int threshold, const Points& points) {
  return plain::collect_points(votes, threshold, points);
}
size_t count_near(const Points& points, size_t n, float slope, float row0, float reach, size_t beat) {
  return plain::count_near(points, n, slope, row0, reach, beat);
}
NearSums sum_near(const Points& points, size_t n, double slope, double row0, double reach) {
  return plain::sum_near(points, n, slope, row0, reach);
}
#else

size_t collect_points(Plane<const int16_t> votes, int threshold, const Points& points) {
  const hn::ScalableTag<int16_t> d16;
  const hn::Repartition<int32_t, decltype(d16)> d32;
  const hn::RebindToFloat<decltype(d32)> df;
  const hn::Rebind<int16_t, decltype(d32)> half;
  const int lanes = static_cast<int>(hn::Lanes(d16)), half_lanes = static_cast<int>(hn::Lanes(d32));
  const auto least16 = hn::Set(d16, static_cast<int16_t>(threshold));
  const auto least32 = hn::Set(d32, threshold);
  const auto steps = hn::Iota(df, 0);
  size_t n = 0;
  for (int v = 0; v < votes.height; ++v) {
    const int16_t* row = votes.row(v);
    const size_t before = n;
    int column = 0;
    for (; column + lanes <= votes.width; column += lanes) {
      if (hn::AllFalse(d16, hn::Gt(hn::LoadU(d16, row + column), least16))) continue;
      for (int part = column; part < column + lanes; part += half_lanes) {
        const auto count = hn::PromoteTo(d32, hn::LoadU(half, row + part));
        const auto mask = hn::RebindMask(df, hn::Gt(count, least32));
        append(df, hn::ConvertTo(df, count), mask, points.votes + n);
        n += append(df, hn::Add(steps, hn::Set(df, static_cast<float>(part))), mask, points.column + n);
      }
    }
    for (; column < votes.width; ++column) {
      points.votes[n] = row[column];
      points.column[n] = static_cast<float>(column);
      n += row[column] > threshold;
    }
    const auto here = hn::Set(df, static_cast<float>(v));
    for (size_t i = before; i < n; i += hn::Lanes(df)) hn::StoreU(here, df, points.row + i);
  }
  return n;
}

size_t count_near(const Points& points, size_t n, float slope, float row0, float reach, size_t beat) {
  constexpr size_t block = 512;  // points from one look at what is left to the next
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const size_t lanes = hn::Lanes(df);
  const auto a = hn::Set(df, slope), b = hn::Set(df, row0), r = hn::Set(df, reach);
  // Multiplied and added one after the other, as in the plain form: a fused step would round differently.
  const auto near = [&](size_t i) HWY_ATTR {
    const auto line = hn::Add(hn::Mul(a, hn::LoadU(df, points.column + i)), b);
    return hn::Lt(hn::Abs(hn::Sub(line, hn::LoadU(df, points.row + i))), r);
  };
  const auto one_more = [&](auto counts, size_t i) HWY_ATTR {
    const auto mask = hn::RebindMask(di, near(i));
    // Where masks have registers of their own a masked addition is one instruction; elsewhere a mask is -1 already.
    if constexpr (HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86) return hn::IfThenElse(mask, hn::Add(counts, hn::Set(di, 1)), counts);
    return hn::Sub(counts, hn::VecFromMask(di, mask));
  };
  size_t count = 0, i = 0;
  while (n - i >= lanes) {
    if (count + (n - i) <= beat) return 0;
    const size_t end = i + std::min(block, (n - i) / lanes * lanes);
    auto even = hn::Zero(di), odd = hn::Zero(di);
    for (; i + 2 * lanes <= end; i += 2 * lanes) {
      even = one_more(even, i);
      odd = one_more(odd, i + lanes);
    }
    if (i < end) {
      even = one_more(even, i);
      i += lanes;
    }
    count += static_cast<size_t>(hn::GetLane(hn::SumOfLanes(di, hn::Add(even, odd))));
  }
  if (i < n) count += hn::CountTrue(df, hn::And(near(i), hn::FirstN(df, n - i)));
  return count > beat ? count : 0;
}

NearSums sum_near(const Points& points, size_t n, double slope, double row0, double reach) {
  const hn::ScalableTag<double> dd;
  const hn::Rebind<float, decltype(dd)> df;
  const size_t lanes = hn::Lanes(dd);
  const auto a = hn::Set(dd, slope), b = hn::Set(dd, row0), r = hn::Set(dd, reach), one = hn::Set(dd, 1.0);
  auto count = hn::Zero(dd), all = count, votes = count, columns = count, rows = count, column_column = count, column_row = count;
  const auto step = [&](size_t i, auto there) HWY_ATTR {
    const auto column = hn::PromoteTo(dd, hn::LoadU(df, points.column + i));
    const auto row = hn::PromoteTo(dd, hn::LoadU(df, points.row + i));
    const auto weight = hn::IfThenElseZero(there, hn::PromoteTo(dd, hn::LoadU(df, points.votes + i)));
    const auto off = hn::Abs(hn::Sub(hn::Add(hn::Mul(a, column), b), row));
    const auto near = hn::And(there, hn::Lt(off, r));
    const auto vote = hn::IfThenElseZero(near, weight);
    const auto vote_column = hn::Mul(vote, column);
    count = hn::Add(count, hn::IfThenElseZero(near, one));
    all = hn::Add(all, weight);
    votes = hn::Add(votes, vote);
    columns = hn::Add(columns, vote_column);
    rows = hn::Add(rows, hn::Mul(vote, row));
    column_column = hn::Add(column_column, hn::Mul(vote_column, column));
    column_row = hn::Add(column_row, hn::Mul(vote_column, row));
  };
  size_t i = 0;
  const auto whole = hn::FirstN(dd, lanes);
  for (; i + lanes <= n; i += lanes) step(i, whole);
  if (i < n) step(i, hn::FirstN(dd, n - i));
  const auto sum = [&](auto lane_sums) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(dd, lane_sums)); };
  return {sum(count), sum(all), sum(votes), sum(columns), sum(rows), sum(column_column), sum(column_row)};
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(collect_points);
HWY_EXPORT(count_near);
HWY_EXPORT(sum_near);
void choose_line_search(Kernels& table) {
  table.collect_points = VDISP_CHOSEN(collect_points);
  table.count_near = VDISP_CHOSEN(count_near);
  table.sum_near = VDISP_CHOSEN(sum_near);
}
}  // namespace vdisp::kernels
#endif
