// live_parameters.h: set, get, save and undo while the daemon runs: thought over in a thread of its own, applied by the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "config/parameters.h"
#include "daemon/control/ring.h"
#include "ipc/command.h"

namespace vdisp {

/// The loop asks and, between two frames, swaps one checked value into the configuration that the stages read: it parses nothing, and
/// touches no file. The thread has a copy of its own, in which it checks what is asked: it is the only one that changes anything.
class LiveParameters {
 public:
  /// `config` is what the stages read, and outlives this. `file`: what save writes to; empty: the daemon was started without one.
  LiveParameters(Config& config, std::filesystem::path file);
  /// Waits for a save that is under way.
  ~LiveParameters();
  LiveParameters(const LiveParameters&) = delete;
  LiveParameters& operator=(const LiveParameters&) = delete;

  /// False: too many are waiting.
  bool ask(const ParameterMessage& message, uint64_t client) noexcept;
  struct Reply {
    uint64_t client = 0;
    ReplyMessage* message = nullptr;  ///< until done()
  };
  /// The next reply; what was set takes effect here. False: none yet. Each is ended by done().
  bool next(Reply& reply) noexcept;
  void done() noexcept { results_.pop(); }
  /// How many times the configuration was changed since the start.
  uint64_t generation() const { return generation_; }

 private:
  struct Request {
    ParameterMessage message;
    uint64_t client;
  };
  struct Result {
    ReplyMessage message;
    uint64_t client;
    const Parameter* changed;  // null: nothing
    Config value;              // of which the loop takes the changed one
  };
  /// What set replaced.
  struct Step {
    const Parameter* row;
    std::string before;
  };

  void think();
  void answer(const Request& request, Result& result);
  void set(const ParameterMessage& message, Result& result);
  void get(const ParameterMessage& message, Result& result);
  void undo(Result& result);
  void save(Result& result);
  void describe(const Parameter& row, ReplyMessage& reply) const;
  std::vector<std::pair<const Parameter*, std::string>> changes() const;

  // The loop's.
  Config& in_use_;
  uint64_t generation_ = 0;
  // The thread's.
  Config config_;
  Config saved_;  // what the file and the command line say
  std::filesystem::path file_;
  std::string file_text_;
  std::vector<Step> steps_;
  // Between both.
  Ring<Request> requests_;
  Ring<Result> results_;
  sem_t asked_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace vdisp
