// shear_simd.cpp: shear and mirror for all instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "daemon/kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "daemon/kernels/shear_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "daemon/kernels/simd.h"

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void shear_row(const uint8_t* in, int width, const RowDisparity& disparity, uint8_t* out) { plain::shear_row(in, width, disparity, out); }
void mirror_row(const uint8_t* in, int width, uint8_t* out) { plain::mirror_row(in, width, out); }
#else

uint8_t sheared(const uint8_t* in, int width, int x, int disparity16) {
  const int from = 16 * x - disparity16, whole = from >> 4, part = from & 15;
  const int left = in[std::clamp(whole, 0, width - 1)], right = in[std::clamp(whole + 1, 0, width - 1)];
  return static_cast<uint8_t>((left * (16 - part) + right * part + 8) >> 4);
}

/// Columns [from, to), all of one disparity.
template <class D16>
HWY_INLINE void shear_block(D16 d16, const uint8_t* in, int width, int from, int to, int disparity16, uint8_t* out) {
  const hn::Rebind<uint8_t, D16> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const int shift = (-disparity16) >> 4, part = (-disparity16) & 15;
  const auto left_part = hn::Set(d16, static_cast<int16_t>(16 - part)), right_part = hn::Set(d16, static_cast<int16_t>(part));
  const auto half = hn::Set(d16, int16_t{8});
  // Inside these columns both pixels exist.
  const int first = std::clamp(-shift, from, to), last = std::clamp(width - 1 - shift, first, to);
  for (int x = from; x < first; ++x) out[x] = sheared(in, width, x, disparity16);
  int x = first;
  for (; x + lanes <= last; x += lanes) {
    const auto left = hn::PromoteTo(d16, hn::LoadU(d8, in + x + shift)), right = hn::PromoteTo(d16, hn::LoadU(d8, in + x + shift + 1));
    const auto sum = hn::Add(hn::Add(hn::Mul(left, left_part), hn::Mul(right, right_part)), half);
    hn::StoreU(hn::DemoteTo(d8, hn::ShiftRight<4>(sum)), d8, out + x);
  }
  for (; x < to; ++x) out[x] = sheared(in, width, x, disparity16);
}

void shear_row(const uint8_t* in, int width, const RowDisparity& disparity, uint8_t* out) {
  if (disparity.per_column == 0) return shear_block(hn::ScalableTag<int16_t>(), in, width, 0, width, disparity.at(0), out);
  constexpr int block = RowDisparity::tilt_block;
  for (int x = 0; x < width; x += block)
    shear_block(hn::CappedTag<int16_t, block>(), in, width, x, std::min(x + block, width), disparity.at(x), out);
}

void mirror_row(const uint8_t* in, int width, uint8_t* out) {
  const hn::ScalableTag<uint8_t> d8;
  const hn::Repartition<uint16_t, decltype(d8)> d16;
  const int lanes = static_cast<int>(hn::Lanes(d8));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto pairs = hn::Reverse(d16, hn::BitCast(d16, hn::LoadU(d8, in + width - lanes - x)));
    hn::StoreU(hn::BitCast(d8, hn::Or(hn::ShiftLeft<8>(pairs), hn::ShiftRight<8>(pairs))), d8, out + x);
  }
  for (; x < width; ++x) out[x] = in[width - 1 - x];
}

#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vdisp::kernels {
HWY_EXPORT(shear_row);
HWY_EXPORT(mirror_row);
void choose_shear(Kernels& table) {
  table.shear_row = VDISP_CHOSEN(shear_row);
  table.mirror_row = VDISP_CHOSEN(mirror_row);
}
}  // namespace vdisp::kernels
#endif
