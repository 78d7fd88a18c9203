// health_report.h: what of the daemon's health the driver does not know: cameras, what came in, recordings, the log; and where all of it
// goes. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/control/command_socket.h"
#include "daemon/metrics.h"
#include "daemon/sources/source.h"

namespace vdisp {

/// For Driver::set_reporter(). What it is made of must outlive it. Throws WriteError where [main] metrics cannot be written.
class HealthReport {
 public:
  HealthReport(const Config& config, const StereoSource& source, const Inputs& inputs, const CommandSocket& control,
               const RecorderStatus& recorder);
  /// No allocation, no wait.
  void operator()(Health& health, const Catalogue& catalogue) noexcept;

 private:
  const StereoSource& source_;
  const Inputs& inputs_;
  const CommandSocket& control_;
  const RecorderStatus& recorder_;
  std::unique_ptr<Metrics> metrics_;
};

}  // namespace vdisp
