// health_report.cpp: counts from where they are kept.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/health_report.h"

#include "daemon/log/log.h"

namespace vdisp {

HealthReport::HealthReport(const Config& config, const StereoSource& source, const Inputs& inputs, const CommandSocket& control,
                           const RecorderStatus& recorder)
    : source_(source), inputs_(inputs), control_(control), recorder_(recorder) {
  if (config.main.metrics.empty()) return;
  metrics_ = std::make_unique<Metrics>(config.main.metrics, config.main.name, [](std::string_view line) { log::warn("{}", line); });
}

void HealthReport::operator()(Health& health, const Catalogue& catalogue) noexcept {
  if (const CameraStatus* status = source_.cameras()) {
    health.cameras = 1;
    health.camera = *status;
  }
  const auto tallies = inputs_.tallies();
  for (size_t kind = 0; kind < tallies.size(); ++kind) {
    health.inputs_accepted[kind] = tallies[kind]->accepted;
    health.inputs_refused[kind] = tallies[kind]->refused;
  }
  control_.count(health);
  health.log_lines_lost = log::lines_lost();
  if (metrics_) metrics_->offer(health, catalogue, recorder_);
}

}  // namespace vdisp
