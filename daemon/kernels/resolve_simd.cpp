// resolve_simd.cpp: the choice between hypotheses, sub-pixel part and reasons for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/resolve_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void resolve_row(const Resolve& r, const Hypothesis& match, const Hypothesis* floor, const RowDisparity& floor_disparity,
                 const uint16_t* texture, int16_t* out) {
  plain::resolve_row(r, match, floor, floor_disparity, texture, out);
}
#else

constexpr int chunk = 64;

/// What was decided for a chunk of columns, to be refined and written.
struct Decided {
  alignas(64) int16_t whole[chunk], cost[chunk], before[chunk], after[chunk];
  alignas(64) int16_t reason[chunk];  // 0: none
};

const int16_t* words(const uint16_t* row) { return reinterpret_cast<const int16_t*>(row); }

template <class D16, class V16 = hn::Vec<D16> >
HWY_INLINE V16 more(D16 d16, V16 cost, int factor) {
  const hn::RebindToUnsigned<D16> du;
  const auto part = hn::MulHigh(hn::BitCast(du, cost), hn::Set(du, static_cast<uint16_t>(factor)));
  return hn::Add(cost, hn::BitCast(d16, part));
}

template <class D16, class V16 = hn::Vec<D16> >
HWY_INLINE V16 whole_of(D16 d16, const Hypothesis& hypothesis, int x) {
  const auto index = hn::LoadU(d16, words(hypothesis.candidates.index) + x);
  return hn::ShiftLeft<4>(hn::Add(index, hn::Set(d16, static_cast<int16_t>(hypothesis.min_disparity))));
}

/// The columns from x on: the first hypothesis alone.
template <class D16>
HWY_INLINE void decide_plain(D16 d16, const Resolve& r, const Hypothesis& match, int x, int at, Decided& to) {
  const Candidates& c = match.candidates;
  hn::Store(whole_of(d16, match, x), d16, to.whole + at);
  hn::Store(hn::LoadU(d16, words(c.cost) + x), d16, to.cost + at);
  hn::Store(hn::LoadU(d16, words(c.before) + x), d16, to.before + at);
  hn::Store(hn::LoadU(d16, words(c.after) + x), d16, to.after + at);
  const auto refused = hn::LoadU(d16, words(c.refused) + x), zero = hn::Zero(d16);
  const auto unique = hn::Eq(hn::And(refused, hn::Set(d16, static_cast<int16_t>(candidate_not_unique))), zero);
  const auto reason = hn::IfThenElse(unique, hn::Set(d16, r.left_right), hn::Set(d16, r.not_unique));
  hn::Store(hn::IfThenElse(hn::Eq(refused, zero), zero, reason), d16, to.reason + at);
}

/// The columns from x on: the cheaper of two, or none of them. `moved` is what the floor's disparities are counted from.
template <class D16, class V16 = hn::Vec<D16> >
HWY_INLINE void decide_both(D16 d16, const Resolve& r, const Hypothesis& match, const Hypothesis& floor, V16 moved, int x, int at,
                            Decided& to) {
  const Candidates &c = match.candidates, &f = floor.candidates;
  const auto zero = hn::Zero(d16);
  const V16 whole = whole_of(d16, match, x), floor_whole = hn::Add(whole_of(d16, floor, x), moved);
  const V16 cost = hn::LoadU(d16, words(c.cost) + x), floor_cost = hn::LoadU(d16, words(f.cost) + x);
  const V16 refused = hn::LoadU(d16, words(c.refused) + x), floor_refused = hn::LoadU(d16, words(f.refused) + x);
  const auto same = hn::Not(hn::Gt(hn::Abs(hn::Sub(floor_whole, whole)), hn::Set(d16, int16_t{same_disparity})));
  const auto cheaper = hn::Not(hn::Gt(floor_cost, cost));
  const auto passes = hn::Eq(refused, zero), floor_passes = hn::Eq(floor_refused, zero);
  const auto only_one = hn::Xor(passes, floor_passes);
  const auto take =
      hn::MaskFromVec(hn::IfThenElse(hn::And(same, only_one), hn::VecFromMask(d16, floor_passes), hn::VecFromMask(d16, cheaper)));
  const V16 taken = hn::IfThenElse(take, floor_cost, cost), rival = hn::IfThenElse(take, cost, floor_cost);
  const auto rivalled = hn::AndNot(same, hn::Not(hn::Gt(rival, more(d16, taken, r.unique))));
  const V16 taken_whole = hn::IfThenElse(take, floor_whole, whole), home = hn::LoadU(d16, words(f.home) + x);
  const auto off = hn::Gt(hn::Abs(hn::Sub(taken_whole, moved)), hn::Set(d16, int16_t{off_floor}));
  const auto explained = hn::And(off, hn::Not(hn::Gt(home, more(d16, taken, r.floor_margin))));
  V16 all = hn::IfThenElse(take, floor_refused, refused);
  if (r.unique > 0)
    all = hn::Or(all, hn::IfThenElseZero(hn::Or(rivalled, explained), hn::Set(d16, static_cast<int16_t>(candidate_not_unique))));
  hn::Store(taken_whole, d16, to.whole + at);
  hn::Store(taken, d16, to.cost + at);
  hn::Store(hn::IfThenElse(take, hn::LoadU(d16, words(f.before) + x), hn::LoadU(d16, words(c.before) + x)), d16, to.before + at);
  hn::Store(hn::IfThenElse(take, hn::LoadU(d16, words(f.after) + x), hn::LoadU(d16, words(c.after) + x)), d16, to.after + at);
  const auto unique = hn::Eq(hn::And(all, hn::Set(d16, static_cast<int16_t>(candidate_not_unique))), zero);
  const auto reason = hn::IfThenElse(unique, hn::Set(d16, r.left_right), hn::Set(d16, r.not_unique));
  hn::Store(hn::IfThenElse(hn::Eq(all, zero), zero, reason), d16, to.reason + at);
}

/// Adds the sub-pixel part to n decided columns and writes them.
void write(const Resolve& r, const Decided& from, const uint16_t* texture, int n, int16_t* out) {
  const hn::CappedTag<int32_t, 16> d32;
  const hn::Rebind<int16_t, decltype(d32)> d16;
  const hn::Rebind<float, decltype(d32)> df;
  const int lanes = static_cast<int>(hn::Lanes(d32));
  const auto least = hn::Set(d32, 16 * r.min_disparity), most = hn::Set(d32, 16 * (r.min_disparity + r.disparities - 1));
  const auto zero = hn::Zero(d32);
  alignas(64) int16_t result[chunk];
  for (int x = 0; x < n; x += lanes) {
    const auto load = [&](const int16_t* row) { return hn::PromoteTo(d32, hn::Load(d16, row + x)); };
    const auto cost = load(from.cost), before = load(from.before), after = load(from.after);
    const auto steep = hn::Sub(hn::Max(before, after), cost);
    const auto rise = hn::ConvertTo(df, hn::ShiftLeft<3>(hn::Sub(before, after)));
    const auto ratio = hn::Div(rise, hn::ConvertTo(df, hn::Max(steep, hn::Set(d32, 1))));
    const auto part = hn::ConvertTo(d32, hn::Floor(hn::Add(ratio, hn::Set(df, 0.5f))));
    const auto disparity = hn::Add(load(from.whole), hn::IfThenElseZero(hn::Gt(steep, zero), part));
    const auto reason = load(from.reason);
    auto value = hn::IfThenElse(hn::Eq(reason, zero), disparity, reason);
    const auto leaves = hn::Or(hn::Lt(disparity, least), hn::Gt(disparity, most));
    value = hn::IfThenElse(leaves, hn::Set(d32, r.outside), value);
    hn::Store(hn::DemoteTo(d16, value), d16, result + x);
  }
  const hn::CappedTag<int16_t, 32> wide16;
  const hn::RebindToUnsigned<decltype(wide16)> wide_u16;
  const int wide = static_cast<int>(hn::Lanes(wide16));
  const auto enough = hn::Set(wide_u16, static_cast<uint16_t>(std::clamp(r.texture_least, 0, UINT16_MAX)));
  int x = 0;
  for (; x + wide <= n; x += wide) {
    const auto poor = hn::RebindMask(wide16, hn::Lt(hn::LoadU(wide_u16, texture + x), enough));
    hn::StoreU(hn::IfThenElse(poor, hn::Set(wide16, r.low_texture), hn::Load(wide16, result + x)), wide16, out + x);
  }
  for (; x < n; ++x) out[x] = texture[x] < r.texture_least ? r.low_texture : result[x];
}

void resolve_row(const Resolve& r, const Hypothesis& match, const Hypothesis* floor, const RowDisparity& floor_disparity,
                 const uint16_t* texture, int16_t* out) {
  const hn::CappedTag<int16_t, 32> d16;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  std::fill_n(out, std::min(match.first, r.width), r.outside);
  const auto plain_until = [&](int from, int to) {
    for (int x = from; x < to; x += chunk) {
      Decided decided;
      const int n = std::min(chunk, to - x);
      for (int i = 0; i < n; i += lanes) decide_plain(d16, r, match, x + i, i, decided);
      write(r, decided, texture + x, n, out + x);
    }
  };
  const int first = floor ? std::clamp(floor->first, match.first, match.last) : match.last;
  const int last = floor ? std::clamp(floor->last, first, match.last) : match.last;
  plain_until(match.first, first);
  for (int x = first; x < last; x += chunk) {
    Decided decided;
    alignas(64) int16_t moved[chunk];
    const int n = std::min(chunk, last - x);
    for (int i = 0; i < chunk; ++i) moved[i] = static_cast<int16_t>(floor_at(floor_disparity, x + i));
    for (int i = 0; i < n; i += lanes) decide_both(d16, r, match, *floor, hn::Load(d16, moved + i), x + i, i, decided);
    write(r, decided, texture + x, n, out + x);
  }
  plain_until(last, match.last);
  const int end = std::max(match.last, std::min(match.first, r.width));
  std::fill_n(out + end, std::max(r.width - end, 0), r.outside);
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(resolve_row);
void choose_resolve(Kernels& table) { table.resolve_row = VDISP_CHOSEN(resolve_row); }
}  // namespace vdisp::kernels
#endif
