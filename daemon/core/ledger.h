// ledger.h: what became of each frame: blind and why, how long it took, too late or not.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// Of the result that the rover drives by, the map: one for each step. Nothing allocates.
class Ledger {
 public:
  /// A result is late when it comes more than `of_exposure_ns` after the middle of the exposure; where that is 0, more than `period_ns`
  /// after the pair was there, as the next one waits then. Both 0: nothing is late.
  void set_deadline(int64_t of_exposure_ns, int64_t period_ns) noexcept {
    deadline_ns_ = of_exposure_ns > 0 ? of_exposure_ns : period_ns;
    of_exposure_ = of_exposure_ns > 0;
  }
  /// The source has given a pair; `there_ns` 0: it had none.
  void pair(int64_t there_ns) noexcept { there_ns_ = there_ns; }
  /// `result` as it is published, at `now_ns`. Recorded and simulated pairs have no exposure: they count from when they were there.
  void result(const Image& result, int64_t now_ns) noexcept {
    if (!result.valid()) {
      ++blind_frames_;
      const auto reason = static_cast<uint32_t>(result.reason);
      ++blind_[reason < Health::reasons ? reason : 0];
    }
    if (there_ns_ == 0) return;
    const int64_t exposed_ns = result.flags & flag_synthetic ? there_ns_ : result.timestamp_ns;
    if (result.valid()) latency_.add(now_ns - exposed_ns);
    if (deadline_ns_ > 0 && now_ns - (of_exposure_ ? exposed_ns : there_ns_) > deadline_ns_) ++misses_;
  }

  void write(Health& health) const noexcept {
    health.blind_frames = blind_frames_;
    for (uint32_t i = 0; i < Health::reasons; ++i) health.blind[i] = blind_[i];
    health.deadline_ns = deadline_ns_;
    health.deadline_of_exposure = of_exposure_;
    health.deadline_misses = misses_;
    health.latency = latency_;
  }

 private:
  int64_t there_ns_ = 0, deadline_ns_ = 0;
  bool of_exposure_ = false;
  uint64_t blind_frames_ = 0, misses_ = 0;
  uint64_t blind_[Health::reasons] = {};
  LatencyHistogram latency_{};
};

}  // namespace vdisp
