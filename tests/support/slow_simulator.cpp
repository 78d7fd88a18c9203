// slow_simulator.cpp: a renderer of black pictures that needs longer for the first than a camera would be waited for.
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstring>
#include <new>
#include <thread>

#include "daemon/sim/simulator.h"

namespace vdisp::sim {
namespace {

class SlowSimulator final : public Simulator {
 public:
  explicit SlowSimulator(const sim_section& parameters) : height_(static_cast<size_t>(parameters.height)) {}
  const Calibration& calibration() const override { return calibration_; }
  void render(uint64_t frame, std::byte* left, std::byte* right, size_t stride) noexcept override {
    if (frame == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    for (std::byte* view : {left, right}) std::memset(view, static_cast<int>(frame) + 1, stride * height_);
  }
  const TruthView& truth(uint64_t) noexcept override { return truth_; }
  Place place(double, double) const noexcept override { return {}; }
  double ground_row(double) const noexcept override { return 0; }
  Odometry rover(uint64_t) const noexcept override { return {}; }
  Imu imu(uint64_t) const noexcept override { return {}; }

 private:
  const size_t height_;
  Calibration calibration_{};
  TruthView truth_{};
};

}  // namespace
}  // namespace vdisp::sim

extern "C" __attribute__((visibility("default"))) vdisp::sim::Simulator* vdisp_make_simulator(const vdisp::sim_section& parameters) {
  return new (std::nothrow) vdisp::sim::SlowSimulator(parameters);
}
