// frame_count.h: the numbers that a camera gives its frames, without their end at 16 bits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp {

/// GigE Vision 1 numbers its blocks from 1 to 65535 and begins again with 1; some cameras go through 0. Others have 64 bits.
class FrameCount {
 public:
  uint64_t of(uint64_t id) noexcept {
    if (id == 0 && count_ > 0) zero_ = 1;
    if (last_ <= most && id < last_ && last_ - id > most / 2) {
      count_ += id + most + zero_ - last_;
    } else {
      count_ = count_ + id - last_;
    }
    last_ = id;
    return count_;
  }
  void reset() noexcept { *this = {}; }

 private:
  static constexpr uint64_t most = 65535;
  uint64_t last_ = 0, count_ = 0;
  unsigned zero_ = 0;
};

}  // namespace vdisp
