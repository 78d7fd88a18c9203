// service.h: tells systemd how the daemon is: ready, status, and that it is alive. Nothing where no $NOTIFY_SOCKET is set.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/service/status.h"

namespace vdisp {

/// The loop notes what happened and never waits; a thread of its own talks to systemd, which may be slow. READY comes after the first good
/// frame, or when the camera is known to be absent, or after 5 s of frames that are all bad. The watchdog is fed when steps were made since
/// it was fed last, blind ones count, and a new reader could attach. Its limit is stretched where the configuration makes steps rare.
class Service {
 public:
  /// `config` is the loop's. `attachable`: could a new reader attach just now; called four times a second by the thread, must not wait.
  Service(const Config& config, std::function<bool()> attachable);
  ~Service() { end(); }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// For each image of a step.
  void see(const Topic& topic, const Image& image) noexcept;
  /// After each step. `fault`: why there was no frame, in the source's words.
  void stepped(Outcome outcome, const Driver& driver, std::string_view fault) noexcept;
  /// The pause from step to step just now; also while one is waited for.
  void expect(int64_t pause_ns) noexcept;
  /// The daemon ends.
  void stopping();

 private:
  void publish() noexcept;
  void work();
  void end();
  void tell(const std::string& state);
  void tell_ready(const Facts& now, int64_t now_ns);
  void feed(const Facts& now, bool attachable);

  const Config& config_;
  const std::function<bool()> attachable_;
  bool active_ = false;

  Facts facts_;            // the loop's
  bool published_ = true;  // as they are
  int64_t frame_ns_ = 0, map_ns_ = 0;

  std::mutex mutex_;  // of all below, up to the next empty line; the loop only tries to take it
  std::condition_variable woken_;
  Facts shared_;
  bool ending_ = false;

  int64_t watchdog_ns_ = 0, stretched_ns_ = 0;  // 0: systemd has no watchdog for us
  uint64_t fed_steps_ = 0;
  int64_t begin_ns_ = 0;
  bool ready_ = false, told_attachable_ = true, told_failure_ = false;
  std::thread thread_;
};

}  // namespace vdisp
