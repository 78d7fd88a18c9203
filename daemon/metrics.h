// metrics.h: what the daemon counts, as a text file for Prometheus: `[main] metrics`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <semaphore.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "ipc/records.h"

namespace vdisp {

/// Text format 0.0.4, as node_exporter's textfile collector reads it. `up`: the daemon goes on.
std::string metrics_text(const Health& health, const Catalogue& catalogue, const RecorderStatus& recorder, const std::string& instance,
                         bool up);

/// A thread that writes the file, whole or not at all, each time it is given new counts. The loop never waits for it.
class Metrics {
 public:
  using Tell = std::function<void(std::string_view)>;
  /// Writes a first file, so that a place where that is not possible ends the start: throws WriteError. `tell`: told when a write
  /// fails later, and when one succeeds again.
  Metrics(std::filesystem::path file, std::string instance, Tell tell);
  /// Writes the last counts, with vdisp_up 0.
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  /// Counts to be written. While the ones before are still being written they are passed over. No allocation, no wait.
  void offer(const Health& health, const Catalogue& catalogue, const RecorderStatus& recorder) noexcept;

 private:
  struct Counts {
    Health health{};
    Catalogue catalogue{};
    RecorderStatus recorder{};
  };
  void work();
  void write(bool up);

  std::filesystem::path file_;
  std::string instance_;
  Tell tell_;
  std::unique_ptr<Counts> counts_;  // the loop's while not full_, else the thread's
  std::atomic<bool> full_{false}, ending_{false};
  bool failed_ = false;
  sem_t news_;
  std::thread thread_;
};

}  // namespace vdisp
