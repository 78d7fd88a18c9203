// aligned.h: memory that begins with a cache line: a vector of 64 bytes that lies in two costs two loads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace vdisp::kernels {

template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) noexcept {}
  T* allocate(size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), line)); }
  void deallocate(T* memory, size_t) noexcept { ::operator delete(memory, line); }
  bool operator==(const AlignedAllocator&) const = default;

 private:
  static constexpr std::align_val_t line{64};
};

template <class T>
using Aligned = std::vector<T, AlignedAllocator<T>>;

}  // namespace vdisp::kernels
