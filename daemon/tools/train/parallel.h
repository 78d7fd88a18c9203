// parallel.h: tasks shared by a few threads that end with them; what one throws is thrown here.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace vdisp::train {

/// Calls body(task, seat) for each task in [0, tasks), seat in [0, threads): who is done takes the next. The first exception ends it.
template <class Body>
void in_parallel(int threads, size_t tasks, const Body& body) {
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex failing;
  const auto work = [&](int seat) {
    try {
      for (size_t task; (task = next++) < tasks;) body(task, seat);
    } catch (...) {
      next = tasks;
      const std::lock_guard lock(failing);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (int seat = 1; seat < threads; ++seat) others.emplace_back(work, seat);
    work(0);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vdisp::train
