// bands.cpp: tasks are claimed by a counter; who waits spins for some microseconds, then sleeps on a futex.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/bands.h"

#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <string>
#include <system_error>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

// Longer than it takes to wake a sleeper, shorter than what would show at 15 Hz.
constexpr int64_t spin_ns = 15'000;

/// Sleeps while `word` is `value`; may wake without cause, and after `limit` (null: never) does.
void sleep_on(std::atomic<uint32_t>& word, uint32_t value, const timespec* limit) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, value, limit, nullptr, 0);
}
void wake(std::atomic<uint32_t>& word, int sleepers) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, sleepers, nullptr, nullptr, 0);
}
static_assert(sizeof(std::atomic<uint32_t>) == 4 && std::atomic<uint32_t>::is_always_lock_free);

void pause() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// True as soon as `done` is, false when it was not within spin_ns.
template <class Done>
bool spin_until(const Done& done) noexcept {
  for (const int64_t end = monotonic_ns() + spin_ns; !done();) {
    if (monotonic_ns() >= end) return false;
    for (int i = 0; i < 8; ++i) pause();
  }
  return true;
}

/// The signals that somebody sends; those of a fault belong to the thread that made it.
sigset_t sent_signals() {
  sigset_t signals;
  sigfillset(&signals);
  for (int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS}) sigdelset(&signals, fault);
  return signals;
}

}  // namespace

Bands::Bands(int threads) {
  const sigset_t sent = sent_signals();
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &sent, &before);  // threads inherit it: signals are main's
  try {
    for (int seat = 1; seat < threads; ++seat) {
      workers_.emplace_back([this, seat] { attend(seat); });
      pthread_setname_np(workers_.back().native_handle(), ("vdisp-band-" + std::to_string(seat)).c_str());
    }
  } catch (const std::system_error& error) {
    const int running = this->threads();
    stop();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw std::system_error(error.code(),
                            "thread " + std::to_string(running + 1) + " of " + std::to_string(threads) + " cannot be started");
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Bands::~Bands() { stop(); }

void Bands::stop() noexcept {
  stop_ = true;
  ++calls_;
  wake(calls_, threads());
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

void Bands::share(int tasks, Call call) noexcept {
  if (tasks <= 1 || workers_.empty() || busy_.exchange(true, std::memory_order_acquire)) {
    for (int task = 0; task < tasks; ++task) call.run(call.body, task, 0);
    return;
  }
  call_ = call;
  left_.store(static_cast<uint32_t>(tasks), std::memory_order_relaxed);
  claims_.store(static_cast<uint64_t>(tasks) << 32, std::memory_order_release);
  // Sequentially consistent with attend(): either the count of sleepers is seen here, or the new call there.
  calls_.fetch_add(1);
  if (asleep_.load() > 0) wake(calls_, tasks - 1);
  work(0);
  wait_for_all();
  busy_.store(false, std::memory_order_release);
}

/// Claims and does tasks until none is left to claim. A claim is good whatever happened since `claims` was read: the number is all it
/// says, and the call cannot end, nor another begin, before the claimed task is done.
void Bands::work(int seat) noexcept {
  uint64_t claims = claims_.load(std::memory_order_acquire);
  while (static_cast<uint32_t>(claims) < claims >> 32) {
    if (!claims_.compare_exchange_weak(claims, claims + 1, std::memory_order_acq_rel, std::memory_order_acquire)) continue;
    call_.run(call_.body, static_cast<int>(static_cast<uint32_t>(claims)), seat);
    if (left_.fetch_sub(1) == 1 && caller_sleeps_.load()) wake(left_, 1);
    claims = claims_.load(std::memory_order_acquire);
  }
}

void Bands::wait_for_all() noexcept {
  if (spin_until([this] { return left_.load(std::memory_order_acquire) == 0; })) return;
  constexpr timespec limit{0, 100'000'000};
  caller_sleeps_.store(true);
  for (uint32_t left = left_.load(); left > 0; left = left_.load()) sleep_on(left_, left, &limit);
  caller_sleeps_.store(false);
}

/// The life of a thread.
void Bands::attend(int seat) noexcept {
  for (uint32_t seen = 0; !stop_; seen = calls_.load()) {
    work(seat);
    const auto called = [&] { return calls_.load() != seen; };
    if (spin_until(called)) continue;
    asleep_.fetch_add(1);
    while (!called()) sleep_on(calls_, seen, nullptr);
    asleep_.fetch_sub(1);
  }
}

}  // namespace vdisp
