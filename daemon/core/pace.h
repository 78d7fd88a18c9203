// pace.h: the loop's wait for the next frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <csignal>
#include <ctime>

#include "daemon/core/clock.h"

namespace vdisp {

/// Waits until a period after `due`, the frame before, and moves it on. A frame that came too late is not caught up with: the next one is
/// due a period from now. `between` is called every 50 ms, so that the heartbeat goes on while a slow source is waited for;
/// `period_ns` is asked anew each time.
template <class Period, class Between>
void wait_for_next(int64_t& due, const volatile std::sig_atomic_t& stop, const Period& period_ns, const Between& between) {
  constexpr int64_t slice_ns = 50'000'000;
  const int64_t last = due, start = monotonic_ns();
  while (!stop) {
    const int64_t period = period_ns(), now = monotonic_ns();
    due = std::max(last + period, start - period);
    if (now >= due) return;
    const timespec pause{0, static_cast<long>(std::min(due - now, slice_ns))};
    nanosleep(&pause, nullptr);
    between();
  }
}

}  // namespace vdisp
