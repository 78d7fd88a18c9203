// service.cpp: sd_notify(3), from facts that the loop leaves behind.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/service/service.h"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "daemon/core/background.h"
#include "daemon/core/clock.h"
#include "daemon/log/log.h"

namespace vdisp {
namespace {

constexpr int64_t second = 1'000'000'000;
constexpr auto tick = std::chrono::milliseconds(250);
constexpr int64_t patience_ns = 5 * second;  // with frames that are all bad, until somebody should be able to look at them
constexpr int steps_missed = 3;              // pauses that the watchdog waits at least

}  // namespace

Service::Service(const Config& config, std::function<bool()> attachable)
    : config_(config), attachable_(std::move(attachable)), active_(std::getenv("NOTIFY_SOCKET") != nullptr) {
  if (!active_) return;
  if (uint64_t watchdog_us = 0; sd_watchdog_enabled(0, &watchdog_us) > 0) watchdog_ns_ = static_cast<int64_t>(watchdog_us) * 1000;
  stretched_ns_ = watchdog_ns_;
  begin_ns_ = monotonic_ns();
  facts_.floors = config.detects("vdisparity");
  thread_ = std::thread([this] { work(); });
}

void Service::see(const Topic& topic, const Image& image) noexcept {
  if (!active_) return;
  if (topic.name == "camera/left") {
    facts_.camera = image.valid() ? Reason::none : image.reason;
    facts_.synthetic = (image.flags & flag_synthetic) != 0;
    // What is drawn or read has a time of its own, not ours.
    frame_ns_ = facts_.synthetic ? image.ready_ns : image.timestamp_ns;
  } else if (topic.name == "map") {
    map_ns_ = image.valid() ? image.ready_ns : 0;
  } else if (topic.name == "floor_model") {
    facts_.floor = image.valid() ? Reason::none : image.reason;
    if (const FloorModel* model = record_of<FloorModel>(image)) {
      facts_.height_m = static_cast<float>(model->height_m);
      facts_.pitch_rad = static_cast<float>(model->pitch_rad);
    }
  }
}

void Service::stepped(Outcome outcome, const Driver& driver, std::string_view fault) noexcept {
  if (!active_) return;
  facts_.steps = driver.steps();
  facts_.blind_steps = driver.blind_steps();
  facts_.good = facts_.good || outcome == Outcome::valid;
  facts_.absent = facts_.absent || facts_.camera == Reason::no_camera;
  facts_.fault[fault.copy(facts_.fault, sizeof facts_.fault - 1)] = 0;
  if (map_ns_ != 0) {
    ++facts_.maps;
    facts_.latency_sum_ns += map_ns_ - frame_ns_;
  }
  map_ns_ = 0;
  publish();
}

void Service::expect(int64_t pause_ns) noexcept {
  if (!active_) return;
  // A camera's pace is waited for in its own place.
  const double rate = config_.image_source.rate;
  const int64_t pause = std::max(pause_ns, rate > 0 ? static_cast<int64_t>(1e9 / rate) : 0);
  if (facts_.pause_ns == pause && published_) return;
  facts_.pause_ns = pause;
  publish();
}

/// Where the thread is just reading, the next call tells.
void Service::publish() noexcept {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  published_ = lock.owns_lock();
  if (published_) shared_ = facts_;
}

void Service::stopping() {
  end();
  if (active_) tell("STOPPING=1\nSTATUS=ending");
}

void Service::end() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  woken_.notify_all();
  thread_.join();
}

void Service::work() {
  begin_in_background("service");
  Facts before, now;
  int64_t told_ns = begin_ns_;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (woken_.wait_for(lock, tick, [this] { return ending_; })) return;
      now = shared_;
    }
    const bool attachable = attachable_();
    const int64_t now_ns = monotonic_ns();
    tell_ready(now, now_ns);
    if (now_ns - told_ns >= second || (ready_ && before.steps == 0)) {
      const std::string trouble = attachable ? "" : "no new reader can attach; ";
      if (now.steps > 0) tell("STATUS=" + trouble + status_line(before, now, static_cast<double>(now_ns - told_ns) * 1e-9));
      before = now;
      told_ns = now_ns;
    }
    feed(now, attachable);
  }
}

void Service::tell_ready(const Facts& now, int64_t now_ns) {
  if (now.steps == 0) begin_ns_ = now_ns;
  if (ready_ || now.steps == 0 || !(now.good || now.absent || now_ns - begin_ns_ > patience_ns)) return;
  ready_ = true;
  tell("READY=1");
}

void Service::feed(const Facts& now, bool attachable) {
  if (attachable != told_attachable_) {
    told_attachable_ = attachable;
    if (attachable)
      log::info("new readers can attach again");
    else
      log::error("no new reader can attach: iceoryx does not answer; the watchdog is not fed until it does");
  }
  if (watchdog_ns_ == 0 || !ready_) return;
  const int64_t limit = std::max(watchdog_ns_, steps_missed * now.pause_ns);
  if (limit != stretched_ns_) tell("WATCHDOG_USEC=" + std::to_string(limit / 1000));
  stretched_ns_ = limit;
  if (now.steps == fed_steps_ || !attachable) return;
  fed_steps_ = now.steps;
  tell("WATCHDOG=1");
}

void Service::tell(const std::string& state) {
  const int result = sd_notify(0, state.c_str());
  if (result >= 0 || told_failure_) return;
  told_failure_ = true;
  log::warn("$NOTIFY_SOCKET: systemd cannot be told how the daemon is: {}", std::strerror(-result));
}

}  // namespace vdisp
