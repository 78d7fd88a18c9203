// count_allocations.cpp: malloc and its kin, counted per thread and passed on to the C library.
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/count_allocations.h"

#include <cstdlib>

namespace {
// Plain thread-local integer: its first use must not allocate.
thread_local uint64_t count = 0;
}  // namespace

namespace vdisp {
uint64_t allocations_of_this_thread() { return count; }
}  // namespace vdisp

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

void* malloc(size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(size_t n, size_t size) {
  ++count;
  return __libc_calloc(n, size);
}
void* realloc(void* memory, size_t size) {
  ++count;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  ++count;
  return __libc_memalign(alignment, size);
}
}
#endif
