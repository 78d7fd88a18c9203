// progress.h: how far a long job is: a bar on a terminal, else a line now and then, on stderr.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>

namespace vdisp::train {

/// Counts may come from several threads.
class Progress {
 public:
  Progress(std::string what, size_t total);
  /// Ends the bar's line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void add(size_t done);

 private:
  using Clock = std::chrono::steady_clock;
  void show(size_t done, Clock::time_point now);

  std::string what_;
  size_t total_;
  bool terminal_;
  Clock::time_point start_;
  std::atomic<size_t> done_{0};
  std::mutex showing_;
  Clock::time_point next_;
  bool shown_ = false;
};

}  // namespace vdisp::train
