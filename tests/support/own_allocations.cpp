// own_allocations.cpp: malloc and its kin, attributed by the call stack.
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/own_allocations.h"

#include <dlfcn.h>
#include <execinfo.h>

#include <cstdlib>
#include <cstring>

namespace {

constexpr int depth = 24;
thread_local bool counting = false;
thread_local uint64_t own = 0, opencv = 0;
thread_local void* first[depth];
thread_local int first_depth = 0;

bool inside_opencv(void* const* frames, int count) {
  for (int i = 0; i < count; ++i) {
    Dl_info info;
    if (dladdr(frames[i], &info) && info.dli_fname && std::strstr(info.dli_fname, "libopencv_")) return true;
  }
  return false;
}

// Under a sanitizer nobody calls it.
[[maybe_unused]] void note() {
  if (!counting) return;
  counting = false;  // what looks at the stack may allocate itself
  void* frames[depth];
  const int count = backtrace(frames, depth);
  if (inside_opencv(frames, count)) {
    ++opencv;
  } else if (own++ == 0) {
    std::memcpy(first, frames, sizeof frames);
    first_depth = count;
  }
  counting = true;
}

}  // namespace

namespace vdisp {

CountAllocations::CountAllocations() {
  void* frames[depth];
  backtrace(frames, depth);  // its first call allocates
  own = opencv = 0;
  counting = true;
}

Allocations CountAllocations::end() {
  counting = false;
  Allocations result{own, opencv, {}};
  char** names = backtrace_symbols(first, own ? first_depth : 0);
  for (int i = 0; own && i < first_depth; ++i) result.first += std::string(names[i]) + "\n";
  std::free(names);
  return result;
}

}  // namespace vdisp

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

void* malloc(size_t size) {
  note();
  return __libc_malloc(size);
}
void* calloc(size_t n, size_t size) {
  note();
  return __libc_calloc(n, size);
}
void* realloc(void* memory, size_t size) {
  note();
  return __libc_realloc(memory, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, size_t alignment, size_t size) {
  note();
  *memory = __libc_memalign(alignment, size);
  return *memory ? 0 : 12;
}
}
#endif
