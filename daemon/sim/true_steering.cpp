// true_steering.cpp: what a driver that knows the world says of the view: labels for a classifier.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/truth_stage.h"

namespace vdisp::sim {
namespace {

class TrueSteering final : public ImageProcessor {
 public:
  explicit TrueSteering(const Simulator& simulator) : report_(*simulator.robot()) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<Decision>()}; }
  Outcome process(std::span<const Image* const>, std::span<Image* const> out) noexcept override {
    Decision& decision = make_record<Decision>(*out[0]);
    decision.steering = report_.steering;
    decision.clearness = report_.clearness;
    decision.since_s = report_.since_s;
    decision.changes = report_.changes;
    return Outcome::valid;
  }

 private:
  const RobotReport& report_;
};

}  // namespace

void add_true_steering(Driver& driver, Handle camera, Simulator& simulator) {
  if (simulator.robot()) driver.add("truth/steering", std::make_unique<TrueSteering>(simulator), {camera});
}

}  // namespace vdisp::sim
