// bands.h: a fixed pool of threads that share the rows of an image, the caller among them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace vdisp {

/// Bodies write rows of their own and are told which: results depend neither on the number of threads nor on who was first. They do
/// not throw. A call allocates nothing and returns when all its bodies have; between calls the threads sleep.
/// One call at a time is shared: from within a body, or while another thread is in a call, bodies run inline, one after the other.
class Bands {
 public:
  /// Starts `threads` - 1 threads. Throws std::system_error where one cannot be started.
  explicit Bands(int threads = 1);
  ~Bands();
  Bands(const Bands&) = delete;
  Bands& operator=(const Bands&) = delete;

  int threads() const { return 1 + static_cast<int>(workers_.size()); }
  /// Into how many bands run() cuts `rows`: as many as there are threads, but each of at least `least` rows; one where there are fewer.
  int count(int rows, int least = 1) const { return rows > 0 ? std::clamp(rows / std::max(least, 1), 1, threads()) : 0; }

  /// Calls body(first, last, band) for count(rows, least) bands of nearly the same height: rows [first, last), from 0 to `rows`, each
  /// once. No two bodies of one call have the same `band`, and it is less than threads(): work space is one for each. A call from
  /// within a body counts its bands anew: it needs work space of its own, not its caller's.
  template <class Body>
  void run(int rows, int least, const Body& body) noexcept {
    const int bands = count(rows, least);
    const auto border = [&](int band) { return static_cast<int>(int64_t{rows} * band / bands); };
    each(bands, [&](int band, int) { body(border(band), border(band + 1), band); });
  }

  /// Calls body(task, seat) for each task in [0, tasks), for work that cannot be cut evenly: who is done takes the next. No two bodies
  /// of one call that run at a time have the same `seat`, and it is less than threads(); the same holds of calls from within.
  template <class Body>
  void each(int tasks, const Body& body) noexcept {
    share(tasks, {&body, [](const void* self, int task, int seat) noexcept { (*static_cast<const Body*>(self))(task, seat); }});
  }

 private:
  /// What is to be called, for as long as the call of each() lasts.
  struct Call {
    const void* body = nullptr;
    void (*run)(const void* body, int task, int seat) noexcept = nullptr;
  };
  void share(int tasks, Call call) noexcept;
  void work(int seat) noexcept;
  void wait_for_all() noexcept;
  void attend(int seat) noexcept;
  void stop() noexcept;

  Call call_;                                    // whoever has claimed a task may read it
  std::atomic<bool> busy_{false};                // a call is being shared
  alignas(64) std::atomic<uint64_t> claims_{0};  // low half: the next task to claim; high half: how many there are
  alignas(64) std::atomic<uint32_t> left_{0};    // tasks not done
  std::atomic<bool> caller_sleeps_{false};
  alignas(64) std::atomic<uint32_t> calls_{0};  // counts calls: what idle threads wait for
  std::atomic<int> asleep_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace vdisp
