// log.h: one line for one event, on stderr: through a bounded ring and a thread of its own, so that the loop never waits for it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <spdlog/spdlog.h>

#include <cstdint>
#include <string>

namespace vdisp::log {

/// Starts the thread. `level`: [main] debug, 0 errors to 3 everything. Under systemd lines carry journald's priorities, else the name of
/// the program. While the ring is full the oldest lines are given up.
void start(int level, const std::string& program = "vdispd");
/// From here on; any thread, no wait.
void set_level(int level);
/// Lines given up since the start while the ring was full.
uint64_t lines_lost();
/// Writes what is waiting and ends the thread. When all that logs has ended: after this there is no logger.
void stop();

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::trace;
using spdlog::warn;

}  // namespace vdisp::log
