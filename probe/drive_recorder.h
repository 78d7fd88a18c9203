// drive_recorder.h: whole frames from the shared memory into a recording; for vdisp-probe record, with and without a window.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "ipc/include/vdisp/control.h"
#include "ipc/record_thread.h"
#include "probe/attach.h"

namespace vdisp {

/// At full rate the tree begins anew with the recording, so that a replay makes the same of it; with a rate it is left alone.
class DriveRecorder {
 public:
  /// Subscribes, and asks the daemon to begin anew. Throws ProbeError.
  DriveRecorder(Client& client, Control& control, const Options& options);
  ~DriveRecorder();
  DriveRecorder(const DriveRecorder&) = delete;
  DriveRecorder& operator=(const DriveRecorder&) = delete;

  /// Takes the newest whole frame, if there is a new one within the limit. False: the recording is over, --seconds have passed.
  /// Throws WriteError, and ProbeError (69) where no frame comes for 10 s, or the daemon was started anew.
  bool poll(Client::Time limit);
  /// Waits until all is written. Throws WriteError.
  void finish();

  uint64_t steps() const { return steps_; }
  uint64_t pairs() const { return pairs_; }
  /// Frames that were missed, at full rate.
  uint64_t lost() const { return lost_; }
  /// Pairs with this label.
  uint64_t of(Label label) const { return labels_[static_cast<size_t>(label)]; }
  /// Of the newest pair.
  Label label() const { return label_; }
  /// What the operator should know, in one line; empty: nothing.
  const std::string& warning() const { return warning_; }

 private:
  using Clock = std::chrono::steady_clock;
  void take_parameters();
  void warn(const std::string& what);
  void ask_for_beginning();
  bool begins(const Image& camera);
  bool is_due(int64_t timestamp_ns);
  void open(const Image& camera);
  void take(const Image& camera);
  std::string value_of(const char* key) const;

  Client& client_;
  Control& control_;
  const Options& options_;
  std::vector<std::string> names_;
  std::vector<Client::Topic> topics_;
  std::vector<Reading> readings_;
  std::unique_ptr<RecordThread> thread_;
  Clock::time_point begun_{}, heard_ = Clock::now(), asked_{};
  int asks_ = 0;
  bool awaited_ = false;  // the frame with which the tree begins anew
  uint64_t epoch_ = 0, last_sequence_ = 0, steps_ = 0, pairs_ = 0, lost_ = 0;
  int64_t due_ns_ = INT64_MIN;
  std::array<uint64_t, static_cast<size_t>(Label::count)> labels_{};
  Label label_ = Label::none;
  std::vector<ParameterInfo> parameters_;
  std::string warning_;
};

}  // namespace vdisp
