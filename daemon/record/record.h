// record.h: `--record DIR`: every step to a folder, from within the loop, written by a thread of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/record/step_taker.h"
#include "ipc/recording.h"

namespace vdisp {

/// No step is lost: where the disk is slower than the loop, the loop waits for it.
class Record {
 public:
  /// Throws WriteError.
  Record(const std::filesystem::path& folder, const RecordingInfo& info, const std::vector<std::pair<std::string, std::string>>& texts,
         const ImageSpec& camera);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  void see(const Topic& topic, const Image& image) noexcept { taker_.see(topic, image); }
  /// After each step. Throws WriteError where an earlier one could not be written: nothing is recorded after that.
  void finish_step();
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
