// decide.cpp: asks the detectors, steps the state machine.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/decide.h"

namespace vdisp {

std::vector<ImageSpec> Decide::check(std::span<const ImageSpec> in) {
  ways_.prepare(in);
  return {record_spec<Decision>()};
}

Outcome Decide::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  Decision& decision = make_record<Decision>(*out[0]);
  Way way{.free = true, .left = true, .clearness = 1};
  decision.decider = Decider::none;
  const auto hear = [&](const Way& says, Decider who) {
    if (decision.decider == Decider::none || (way.free && !says.free)) {
      decision.decider = who;
      way.left = says.left;
    }
    way.free = way.free && says.free;
    way.clearness = std::min(way.clearness, says.clearness);
  };
  if (in[0]->valid()) {
    if (ways_.has_map()) hear(ways_.map(in), Decider::vdisparity);
  } else if (ways_.snow(in).free) {
    out[0]->reason = in[0]->reason;
    return Outcome::invalid;
  }
  if (ways_.has_snow()) hear(ways_.snow(in), Decider::snow);
  decision.steering = machine_.step(way, in[0]->timestamp_ns, config_.decide.hold, config_.decide.clearEnough);
  decision.clearness = way.clearness;
  decision.since_s = machine_.since_s();
  decision.changes = machine_.changes();
  return Outcome::valid;
}

}  // namespace vdisp
