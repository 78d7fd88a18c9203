// flight_recorder.h: the last seconds in memory, raw, and written to a folder when something happens.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "config/config.h"
#include "daemon/record/flight_folder.h"
#include "ipc/recording.h"
#include "ipc/step_taker.h"

namespace vdisp {

/// All calls are the loop's: none allocates, locks or waits. A thread of its own writes; meanwhile the ring goes on, and only a step
/// whose place is still to be written is not kept, and counted.
class FlightRecorder {
 public:
  /// Files for each folder: name and content, as of when it is written. Called by the thread.
  using Texts = std::function<std::vector<std::pair<std::string, std::string>>()>;
  /// [recorder] memory bounds the ring.
  FlightRecorder(const Config& config, const ImageSpec& camera, RecordingInfo info, Texts texts);
  /// Waits for the folder that is being written, but not for a slow disk: a folder is given up after 5 s.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// Of every image of a step. Notices what is lost: camera and floor, three steps in a row, and events (bump..., dump-flight).
  void see(std::string_view topic, const Image& image) noexcept;
  /// The step is over; `now_ns` is CLOCK_MONOTONIC.
  void finish_step(int64_t now_ns) noexcept;
  /// Somebody wants the folder: written as soon as none is being written.
  void ask(FlightCause cause) noexcept;
  /// Likewise, but what happens again within the time that a folder holds is in the last one already, as good as.
  void happened(FlightCause cause, int64_t now_ns) noexcept;
  /// Members that tell of the flight recorder.
  void tell(RecorderStatus& status) const noexcept;

 private:
  struct Watched {
    bool known = false;  // it was there once
    int missing = 0;     // steps in a row
  };
  /// True at the step in which it counts as lost.
  static bool lost(Watched& subject, bool there) noexcept;
  void begin_step() noexcept;
  void take_result() noexcept;
  void start_writing(int64_t now_ns) noexcept;
  void run() noexcept;
  void write();
  void write_to(const std::filesystem::path& folder);

  const Config& config_;
  const ImageSpec camera_;
  const RecordingInfo info_;
  const Texts texts_;
  std::vector<TakenStep> ring_;
  std::vector<int64_t> taken_ns_;  // of each step in the ring
  StepTaker taker_;
  uint64_t next_ = 0;    // number of the next step; its place is next_ % ring_.size()
  bool taking_ = false;  // the next step has its place
  Watched view_, floor_;
  bool camera_there_ = false;
  FlightCause asked_ = FlightCause::none;
  int64_t begun_ns_ = INT64_MIN / 2;  // the last folder
  RecorderStatus status_{};

  // The job: the loop's until it is given, the thread's until it is done.
  static constexpr uint64_t nothing = UINT64_MAX;
  std::atomic<uint64_t> needed_from_{nothing};  // steps from here on are still to be written
  std::atomic<bool> busy_{false};
  uint64_t first_ = 0, end_ = 0;
  FlightRoom room_;
  FlightCause cause_ = FlightCause::none;
  std::string result_;
  bool failed_ = false;
  std::atomic<int64_t> ending_ns_{0};  // 0: not ending
  std::counting_semaphore<> given_{0};
  std::thread thread_;
};

}  // namespace vdisp
