// live_parameters.h: set, get, save, undo, and vdisp.cfg read again: thought over in a thread, applied by the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "config/parameters.h"
#include "daemon/control/config_origin.h"
#include "daemon/control/config_watch.h"
#include "daemon/control/reload.h"
#include "daemon/control/ring.h"
#include "ipc/command.h"

namespace vdisp {

/// The loop asks and, between two frames, swaps checked values into the configuration that the stages read: it parses nothing, and
/// touches no file. The thread has a copy of its own, in which it checks what is asked: it is the only one that changes anything.
class LiveParameters {
 public:
  /// One line for the log, from the thread; `fault`: something is wrong.
  using Tell = std::function<void(std::string_view line, bool fault)>;
  /// `config` is what the stages read, and outlives this.
  LiveParameters(Config& config, ConfigOrigin origin, Tell tell);
  /// Waits for a save that is under way.
  ~LiveParameters();
  LiveParameters(const LiveParameters&) = delete;
  LiveParameters& operator=(const LiveParameters&) = delete;

  /// False: too many are waiting.
  bool ask(const ParameterMessage& message, const Sender& sender) noexcept;
  struct Reply {
    uint64_t client = 0;              ///< 0: it answers nobody
    ReplyMessage* message = nullptr;  ///< until done()
  };
  /// The next reply; what was changed takes effect here. False: none yet. Each is ended by done().
  bool next(Reply& reply) noexcept;
  void done() noexcept { results_.pop(); }
  /// How many times the configuration was changed since the start.
  uint64_t generation() const { return generation_; }
  /// How many times the file was read again and taken, and not taken for its faults.
  uint64_t reloads() const { return reloads_; }
  uint64_t reloads_refused() const { return reloads_refused_; }
  /// vdisp.cfg as it is understood now. Any thread but the loop: it may wait for another one.
  std::string text() const;

 private:
  struct Request {
    ParameterMessage message;
    Sender sender;
  };
  struct Result {
    ReplyMessage message;
    uint64_t client;
    std::vector<const Parameter*> changed;
    Config value;  // of which the loop takes the changed ones
  };
  /// What one change replaced.
  struct Step {
    std::vector<std::pair<const Parameter*, std::string>> before;
    uint64_t connection;  // that set it; 0: another reading of the file
  };
  /// Of a slider that still moves: not told yet.
  struct Slide {
    const Parameter* row = nullptr;
    std::string before;
    Sender sender;
  };

  void think();
  void hear(ConfigWatch::Event event);
  Result* free_result();
  void answer_all();
  void answer(const Request& request, Result& result);
  void set(const Request& request, Result& result);
  void get(const ParameterMessage& message, Result& result);
  void undo(const Sender& sender, Result& result);
  void save(const Sender& sender, Result& result);
  void describe(const Parameter& row, ReplyMessage& reply) const;
  std::vector<std::pair<const Parameter*, std::string>> changes() const;
  void keep(Step step);
  std::string read_again(Precedence precedence, const std::string& origin, Result& result);
  std::string take(const Config& now, Precedence precedence, const std::string& origin, Result& result);
  void reload(Precedence precedence, const std::string& origin);
  void tell_change(const Parameter& row, const std::string& before, const std::string& origin);
  void tell_slide();
  void write_text();

  // The loop's.
  Config& in_use_;
  uint64_t generation_ = 0;
  // The thread's.
  Config config_;
  Config saved_;  // what the file and the command line say
  ConfigOrigin origin_;
  Tell tell_;
  std::string file_text_;  // as last taken or saved
  std::string seen_text_;  // as last read, faults or not
  std::vector<Step> steps_;
  Slide slide_;
  // Between both.
  Ring<Request> requests_;
  Ring<Result> results_;
  ConfigWatch watch_;
  mutable std::mutex text_mutex_;
  std::string text_;
  std::atomic<uint64_t> reloads_{0}, reloads_refused_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace vdisp
