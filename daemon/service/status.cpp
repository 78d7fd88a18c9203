// status.cpp: the words of the status line.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/service/status.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace vdisp {
namespace {

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char line[160];
  va_list values;
  va_start(values, format);
  const int length = std::vsnprintf(line, sizeof line, format, values);
  va_end(values);
  return {line, static_cast<size_t>(std::clamp(length, 0, static_cast<int>(sizeof line) - 1))};
}

std::string floor_words(const Facts& now) {
  if (!now.floors) return "";
  if (now.floor != Reason::none) return ", no floor: " + std::string(describe(now.floor));
  if (std::isnan(now.height_m)) return ", floor found";
  constexpr double degrees = 180 / 3.14159265358979;
  return text(", floor %.2f m below, pitch %.1f deg", static_cast<double>(now.height_m), static_cast<double>(now.pitch_rad) * degrees);
}

}  // namespace

std::string status_line(const Facts& before, const Facts& now, double seconds) {
  const double rate = static_cast<double>(now.steps - before.steps) / std::max(seconds, 1e-3);
  if (now.camera != Reason::none) {
    const std::string why = now.fault[0] ? now.fault : std::string(describe(now.camera));
    return (now.absent && !now.good ? "camera absent, blind at " : "blind at ") + text("%.1f Hz: ", rate) + why;
  }
  std::string line = text("%.1f Hz", rate);
  if (now.maps > before.maps) {
    const double mean = static_cast<double>(now.latency_sum_ns - before.latency_sum_ns) / static_cast<double>(now.maps - before.maps);
    line += text(", map %.1f ms after the %s", mean * 1e-6, now.synthetic ? "frame" : "exposure");
  }
  line += floor_words(now);
  const uint64_t blind = now.blind_steps - before.blind_steps;
  line += now.synthetic ? ", frames of no camera" : ", camera delivers";
  return blind ? line + text(", %llu of %llu steps blind", static_cast<unsigned long long>(blind),
                             static_cast<unsigned long long>(now.steps - before.steps))
               : line;
}

}  // namespace vdisp
