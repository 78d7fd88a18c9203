// status.h: what the loop tells of itself, and the line that `systemctl status` shows of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// As of the last step. Plain: copied whole.
struct Facts {
  uint64_t steps = 0, blind_steps = 0;
  uint64_t maps = 0;           // valid ones
  int64_t latency_sum_ns = 0;  // of these: from the exposure, or from the frame where it has no exposure
  int64_t pause_ns = 0;        // that the configuration puts between two steps
  bool good = false;           // one frame was, ever
  bool absent = false;         // the camera was known to be missing, ever
  bool synthetic = false;
  bool floors = false;                // there is a search for them
  Reason camera = Reason::none;       // why the last step is blind
  Reason floor = Reason::none;        // why it has no floor
  float height_m = 0, pitch_rad = 0;  // of the camera over the floor; NaN where not known
  char fault[200] = "";               // the source's own words for `camera`
};

/// One line: rate, latency, floor, camera; of what lies between the two, `seconds` apart.
std::string status_line(const Facts& before, const Facts& now, double seconds);

}  // namespace vdisp
