// private_copy.h: a file's bytes in memory of the process, which stay what they are whatever becomes of the file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>

namespace vdisp::snow {

/// Page-aligned, read-only once it is filled. A mapping of the file itself would end the process by SIGBUS where the file is cut off
/// under it, and show what is written over it. Pages of zeros take no memory: most of a model's are.
class PrivateCopy {
 public:
  PrivateCopy() = default;
  PrivateCopy(PrivateCopy&& other) noexcept { *this = std::move(other); }
  PrivateCopy& operator=(PrivateCopy&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(bytes_, other.bytes_);
    std::swap(mapped_, other.mapped_);
    return *this;
  }
  ~PrivateCopy();

  /// The first `bytes` of an open file, or as many as there are: see size(). False, with errno: it cannot be read, or there is no memory.
  bool fill(int file, size_t bytes);
  const std::byte* data() const { return static_cast<const std::byte*>(memory_); }
  size_t size() const { return bytes_; }

 private:
  void* memory_ = nullptr;
  size_t bytes_ = 0, mapped_ = 0;
};

}  // namespace vdisp::snow
