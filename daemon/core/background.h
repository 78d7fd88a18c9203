// background.h: threads beside the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>
#include <sched.h>

namespace vdisp {

/// First call of a thread that works beside the loop: it has this name (15 letters at most), and whatever [main] scheduling says, it is not
/// in real time, which it would have from the thread that started it: of equal priority it would keep the loop waiting. Always permitted.
inline void begin_in_background(const char* name) noexcept {
  pthread_setname_np(pthread_self(), name);
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);
}

}  // namespace vdisp
