// drive.h: stage `drive`: how fast the rover is to go and to turn: the decision's command, or the operator's.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"
#include "ipc/records.h"

namespace vdisp {

/// Decision, in/drive, and with two detectors their CrossCheck (all even_blind) to a DriveCommand.
///
/// Ahead the speed is [decide] leastSpeed to speed, by the decision's clearness (paper census + SNoW, outlook: fast where nothing is near,
/// slow where something is); it turns standing. While the detectors disagree, and half a second longer, it goes ahead at leastSpeed and
/// turns at half the rate: two that contradict each other by turns agree in no frame that counts. So it does where one of them turns it
/// alone while the other is blind. The operator's order wins while it is younger than 300 ms, also where the decision is blind, and its
/// command ends then, however late the next frame is (what is replayed has no end: its clock is another one). Otherwise a blind decision is
/// a blind command, and the rover stops.
class Drive final : public ImageProcessor {
 public:
  static constexpr int64_t order_ns = 300'000'000;  ///< the operator's dead-man

  explicit Drive(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;
  void begin_anew() noexcept override { has_disagreed_ = false; }

 private:
  bool slowed(const Image& decided, const Image& cross_check) noexcept;

  const Config& config_;
  int64_t disagreed_ns_ = 0;
  bool has_disagreed_ = false;
};

}  // namespace vdisp
