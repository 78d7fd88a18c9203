// record_thread.h: steps to a folder, taken in a loop and written by a thread of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ipc/recording.h"
#include "ipc/step_taker.h"

namespace vdisp {

/// No step is lost: where the disk is slower than the loop, the loop waits for it.
class RecordThread {
 public:
  /// `begin`: first call of the thread. Throws WriteError.
  RecordThread(const std::filesystem::path& folder, const RecordingInfo& info,
               const std::vector<std::pair<std::string, std::string>>& texts, const ImageSpec& camera, std::function<void()> begin = {});
  ~RecordThread();
  RecordThread(const RecordThread&) = delete;
  RecordThread& operator=(const RecordThread&) = delete;

  void see(std::string_view topic, const Image& image) noexcept { taker_.see(topic, image); }
  /// After each step; gives its label. Throws WriteError where an earlier one could not be written: nothing is recorded after that.
  Label finish_step();
  /// Waits until all is written. Throws WriteError.
  void finish();
  uint64_t pairs() const { return writer_.pairs(); }  ///< after finish()

 private:
  void write();
  void stop();

  StepTaker taker_;
  std::vector<TakenStep> steps_;  // a ring: the loop fills filled_, the thread empties written_
  size_t filled_ = 0, written_ = 0;
  bool ending_ = false;
  std::optional<WriteError> failed_;
  std::mutex mutex_;
  std::condition_variable changed_;
  RecordingWriter writer_;  // the thread's
  std::thread thread_;
};

}  // namespace vdisp
