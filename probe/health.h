// health.h: the daemon's losses and its latency, in words and as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "ipc/records.h"

namespace vdisp {

/// Everything that Health holds, times in ms.
nlohmann::ordered_json health_json(const Health& health);
/// What was lost, a line for each kind that lost anything, and one for latency and deadline.
std::string health_words(const Health& health);

/// What is recorded, what the flight recorder holds, wrote and lost; `flight` is null where there is no flight recorder.
nlohmann::ordered_json recorder_json(const RecorderStatus& recorder);
/// A line where the flight recorder lost steps or folders, else nothing.
std::string recorder_words(const RecorderStatus& recorder);

/// count, mean_ms, p50_ms, p99_ms, p999_ms, max_ms; null where nothing was counted.
nlohmann::ordered_json latency_json(const LatencyHistogram& latency);
/// "p50 5.2 ms  p99 8.1 ms  p99.9 9.0 ms  max 12.0 ms"
std::string latency_words(const LatencyHistogram& latency);

}  // namespace vdisp
