// private_copy.cpp: reads a file page by page into anonymous memory.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/private_copy.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace vdisp::snow {
namespace {

constexpr size_t page = 4096;

}  // namespace

PrivateCopy::~PrivateCopy() {
  if (memory_) munmap(memory_, mapped_);
}

bool PrivateCopy::fill(int file, size_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  memory_ = memory, mapped_ = bytes;
  static constexpr std::array<std::byte, page> zeros{};
  std::array<std::byte, 64 * page> part;
  while (bytes_ < bytes) {
    const ssize_t now = pread(file, part.data(), std::min(part.size(), bytes - bytes_), static_cast<off_t>(bytes_));
    if (now < 0 && errno == EINTR) continue;
    if (now < 0) return false;
    if (now == 0) break;
    const auto count = static_cast<size_t>(now);
    for (size_t from = 0; from < count; from += page) {
      const size_t size = std::min(page, count - from);
      if (std::memcmp(part.data() + from, zeros.data(), size) != 0)
        std::memcpy(static_cast<std::byte*>(memory_) + bytes_ + from, part.data() + from, size);
    }
    bytes_ += count;
  }
  return mprotect(memory_, mapped_, PROT_READ) == 0;
}

}  // namespace vdisp::snow
