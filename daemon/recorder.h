// recorder.h: all that records a run: `--record DIR`, the flight recorder, and the stage that tells of both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/geometry/calibration.h"
#include "daemon/record/flight_recorder.h"
#include "ipc/record_thread.h"

namespace vdisp {

/// The loop's. But for finish_step() with --record no call waits.
class Recorder {
 public:
  /// The stage `recorder`, which shows what this was at the end of the step before.
  void add_report(Driver& driver);
  /// When the tree is built. `folder`: of --record, empty: none; it makes the simulator's labels as well, where there are some.
  /// Throws WriteError.
  /// `config_text`: vdisp.cfg as it is understood when it is called, by another thread.
  void start(const std::string& folder, Driver& driver, const Config& config, const std::optional<Calibration>& calibration, uint64_t epoch,
             const std::function<std::string()>& config_text);
  /// As it was at the end of the last step.
  const RecorderStatus& status() const { return status_; }
  void see(const Topic& topic, const Image& image) noexcept;
  /// After each step. Throws WriteError where --record cannot go on.
  void finish_step();
  /// SIGUSR1: the flight recorder is to write what it holds.
  void ask_flight() noexcept;
  /// Writes what waits, and says so. Throws WriteError.
  void finish();

 private:
  RecorderStatus status_{};
  std::unique_ptr<RecordThread> record_;
  std::unique_ptr<FlightRecorder> flight_;
  std::string folder_;
};

}  // namespace vdisp
