// kept.h: a copy of an image of the daemon's: a display outlives the daemon, and holds none of its blocks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <cstring>
#include <memory>

#include "ipc/image.h"

namespace vdisp {

class KeptImage {
 public:
  void keep(const Image& image) {
    const uint32_t bytes = image.spec.bytes();
    if (bytes > room_) {
      const uint32_t rounded = (bytes + 63u) & ~63u;
      memory_.reset(static_cast<std::byte*>(std::aligned_alloc(64, rounded)));
      if (!memory_) throw std::bad_alloc();
      room_ = rounded;
    }
    std::memcpy(memory_.get(), static_cast<const void*>(&image), bytes);
    kept_ = true;
  }
  void drop() { kept_ = false; }
  /// Null: nothing is kept.
  const Image* get() const { return kept_ ? reinterpret_cast<const Image*>(memory_.get()) : nullptr; }

 private:
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  std::unique_ptr<std::byte[], Free> memory_;
  uint32_t room_ = 0;
  bool kept_ = false;
};

}  // namespace vdisp
