// drive.cpp: a decision in m/s and rad/s.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/drive.h"

#include <algorithm>

namespace vdisp {
namespace {

constexpr int64_t slow_after_ns = 500'000'000;

}  // namespace

std::vector<ImageSpec> Drive::check(std::span<const ImageSpec> in) {
  if (in.size() != 2 && in.size() != 3)
    throw FormatError("takes decision, operator's order and cross-check, was given " + std::to_string(in.size()) + " images");
  if (in[0] != record_spec<Decision>()) throw FormatError("the first input is no decision");
  if (in[1] != record_spec<DriveOrder>()) throw FormatError("the second input is no operator's order");
  if (in.size() == 3 && in[2] != record_spec<CrossCheck>()) throw FormatError("the third input is no cross-check");
  return {record_spec<DriveCommand>()};
}

/// They disagree, or one decided alone as the other is blind, or so it was a moment ago.
bool Drive::slowed(const Image& decided, const Image& cross_check) noexcept {
  const int64_t now_ns = decided.timestamp_ns;
  if (cross_check.valid() ? !cross_check.row<CrossCheck>(0)->agree : decided.valid()) {
    disagreed_ns_ = now_ns;
    has_disagreed_ = true;
  }
  return has_disagreed_ && now_ns >= disagreed_ns_ && now_ns - disagreed_ns_ < slow_after_ns;
}

Outcome Drive::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& decided = *in[0];
  const bool slow = in.size() == 3 && slowed(decided, *in[2]);
  const auto& decision = *decided.row<Decision>(0);
  DriveCommand& command = make_record<DriveCommand>(*out[0]);
  if (decided.valid()) command.steering = decision.steering;
  const auto& order = *in[1]->row<DriveOrder>(0);
  if (in[1]->valid() && order.age_s < static_cast<double>(order_ns) * 1e-9) {
    command.speed = order.speed;
    command.turn_rate = order.turn_rate;
    command.decider = Decider::operator_order;
    command.valid_until_ns = in[1]->flags & flag_synthetic ? 0 : order.timestamp_ns + order_ns;
    return Outcome::valid;
  }
  if (!decided.valid()) {
    out[0]->reason = decided.reason;
    return Outcome::invalid;
  }
  const auto& p = config_.decide;
  command.decider = decision.decider;
  command.slowed = slow;
  if (decision.steering == Steering::forward) {
    command.speed = p.leastSpeed + (slow ? 0 : decision.clearness) * (p.speed - p.leastSpeed);
  } else {
    const double rate = slow ? p.turnRate / 2 : p.turnRate;
    command.turn_rate = decision.steering == Steering::turn_left ? rate : -rate;
  }
  return Outcome::valid;
}

}  // namespace vdisp
