// settings.h: section [drive] of vdisp.cfg, read and checked: texts as phrases, times in ns.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/tools/drive/phrase.h"
#include "daemon/tools/drive/wheels.h"

namespace vdisp::drive {

inline constexpr size_t longest_command = 256;

struct Settings {
  drive_section from;
  Phrase command, stop, start;
  int64_t period_ns = 0;

  /// What a command says of these wheels: the controller's units, and its idea of which way a wheel turns.
  Motion motion(const Wheels& wheels) const;
  bool stop_is_limited() const { return !std::isnan(from.stopDeceleration); }
};

/// All that is wrong goes to `complaints`, a line each; with any, the settings are not to be used. `port`: what is used instead of
/// [drive] port where it is not empty.
Settings read_settings(const Config& config, const std::string& port, std::vector<std::string>& complaints);

}  // namespace vdisp::drive
