// realtime.h: what [main] asks of the machine: scheduling, processors, locked memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "config/config.h"

namespace vdisp {

/// exit_code: 77 this user may not, 78 the machine has no such processor. One line.
class RealtimeError : public std::runtime_error {
 public:
  RealtimeError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// `cpus`, `scheduling` and `priority`, for the calling thread and all that it will start: call it before they are. Throws RealtimeError.
void take_processors(const main_section& main);
/// `lockMemory`, for what is mapped by now: call it when the tree is built. Throws RealtimeError.
void lock_memory(const main_section& main);

}  // namespace vdisp
