// decide.cpp: asks the detectors, steps the state machine.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/decide.h"

namespace vdisp {

std::vector<ImageSpec> Decide::check(std::span<const ImageSpec> in) {
  if (in.empty() || in.size() > 2)
    throw FormatError("takes a grid, and its reasons where it has some, was given " + std::to_string(in.size()) + " images");
  require(in[0], in.size() == 2 ? Pixel::int8 : Pixel::count16, "the grid");
  if (in.size() == 2) {
    require(in[1], Pixel::gray8, "the reason");
    require_same_size(in[0], in[1]);
  }
  map_.prepare(in[0]);
  return {record_spec<Decision>()};
}

Outcome Decide::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const MapWay way = map_.look(*in[0], in.size() == 2 ? in[1] : nullptr);
  Decision& decision = make_record<Decision>(*out[0]);
  decision.steering = machine_.step(way, in[0]->timestamp_ns, config_.decide.hold);
  decision.decider = Decider::vdisparity;
  decision.clearness = way.clearness;
  decision.since_s = machine_.since_s();
  decision.changes = machine_.changes();
  return Outcome::valid;
}

}  // namespace vdisp
