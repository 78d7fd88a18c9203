// camera_clock.h: a camera's clock in terms of ours, from when its frames arrived.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace vdisp {

/// A frame arrives some time after it was taken, never before: the least difference of both clocks over some seconds is the offset and
/// the least delay. Two clocks drift apart by some 50 us a second at most, so old differences are forgotten after one to two spans.
class CameraClock {
 public:
  static constexpr int64_t span_ns = 4'000'000'000;
  static constexpr int64_t jump_ns = 1'000'000'000;

  /// `camera_ns` of a frame that arrived at `arrival_ns` (CLOCK_MONOTONIC): when it was taken by our clock, late by the least delay, but
  /// never after it arrived. A clock that jumped by more than a second, or went back, begins anew.
  int64_t when(int64_t camera_ns, int64_t arrival_ns) noexcept {
    const int64_t offset = arrival_ns - camera_ns;
    const bool jumped = least() != none && (offset > least() + jump_ns || offset < least() - jump_ns);
    if (jumped || (last_camera_ns_ != none && camera_ns <= last_camera_ns_)) {
      if (last_camera_ns_ != none) ++jumps_;
      least_ = {none, none};
    }
    if (least_[0] == none || arrival_ns - started_ns_ > span_ns) {
      least_ = {offset, least_[0]};
      started_ns_ = arrival_ns;
    }
    least_[0] = std::min(least_[0], offset);
    last_camera_ns_ = camera_ns;
    return camera_ns + least();
  }
  /// How often it began anew.
  uint64_t jumps() const noexcept { return jumps_; }
  void reset() noexcept { least_ = {none, none}, last_camera_ns_ = none; }

 private:
  static constexpr int64_t none = std::numeric_limits<int64_t>::max();
  int64_t least() const noexcept { return std::min(least_[0], least_[1]); }

  std::array<int64_t, 2> least_{none, none};  // of this span, of the one before
  int64_t started_ns_ = 0, last_camera_ns_ = none;
  uint64_t jumps_ = 0;
};

}  // namespace vdisp
