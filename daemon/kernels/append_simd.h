// append_simd.h: lists made with vectors: the lanes of a mask written one behind the other.
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once for each instruction set, like the files that include it.
#ifndef VDISP_APPEND_TABLE
#define VDISP_APPEND_TABLE
#include <array>
#include <cstdint>
#include <type_traits>

namespace vdisp::kernels {

/// For each mask of the lanes of 16 bytes: the bytes of the lanes that are set, first ones first.
template <int lane_bytes>
inline constexpr auto kept_bytes = [] {
  std::array<std::array<uint8_t, 16>, size_t{1} << (16 / lane_bytes)> table{};
  for (size_t mask = 0; mask < table.size(); ++mask) {
    size_t to = 0;
    for (size_t byte = 0; byte < 16; ++byte)
      if (mask >> (byte / lane_bytes) & 1) table[mask][to++] = static_cast<uint8_t>(byte);
  }
  return table;
}();

}  // namespace vdisp::kernels
#endif

#if defined(VDISP_APPEND_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef VDISP_APPEND_SIMD
#undef VDISP_APPEND_SIMD
#else
#define VDISP_APPEND_SIMD
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vdisp::kernels {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

/// Writes the lanes of `v` (2 or 4 bytes each) that are set in `mask` to `to`, and returns how many. A whole vector, and 16 bytes at
/// least, may be written. Not Highway's CompressStore: without an instruction for it, GCC 12 makes that one copy its table to
/// the stack each time (500 instructions a vector), and the one instruction that compresses into memory is slow.
template <class D, class V, class M, class T = hwy::HWY_NAMESPACE::TFromD<D>>
HWY_INLINE size_t append(D d, V v, M mask, T* to) {
  namespace hn = hwy::HWY_NAMESPACE;
  constexpr bool native = sizeof(T) == 4 ? HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86 : HWY_TARGET == HWY_AVX3_DL;
  if constexpr (native || HWY_HAVE_SCALABLE) {
    hn::StoreU(hn::Compress(v, mask), d, to);
    return hn::CountTrue(d, mask);
  } else {
    constexpr size_t block = 16 / sizeof(T);
    const hn::FixedTag<uint8_t, 16> bytes;
    HWY_ALIGN T lanes[HWY_MAX_BYTES / sizeof(T)];
    alignas(8) uint8_t bits[8] = {};
    hn::Store(v, d, lanes);
    hn::StoreMaskBits(d, mask, bits);
    size_t n = 0;
    for (size_t i = 0; i < hn::Lanes(d); i += block) {
      const uint32_t kept = static_cast<uint32_t>(bits[i / 8]) >> (i % 8) & ((1u << block) - 1);
      const auto order = hn::LoadU(bytes, kept_bytes<sizeof(T)>[kept].data());
      const auto packed = hn::TableLookupBytes(hn::Load(bytes, reinterpret_cast<const uint8_t*>(lanes + i)), order);
      hn::StoreU(packed, bytes, reinterpret_cast<uint8_t*>(to + n));
      n += hwy::PopCount(kept);
    }
    return n;
  }
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace vdisp::kernels
HWY_AFTER_NAMESPACE();
#endif
