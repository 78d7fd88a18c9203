// reload.h: what another reading of vdisp.cfg changes in a running daemon.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "config/parameters.h"

namespace vdisp {

/// What holds where a value was set by hand and not saved. `file`: the file's, for SIGHUP. `hand`: the one set by hand, unless the file
/// says something else than it did before: for a file that somebody edits while others tune.
enum class Precedence { file, hand };

struct Reload {
  std::vector<const Parameter*> taken;    ///< live ones that get the file's value
  std::vector<const Parameter*> kept;     ///< live ones that stay as they were set by hand
  std::vector<const Parameter*> restart;  ///< others that differ from what runs
  std::string fault;                      ///< what is taken contradicts what needs a restart: then nothing is
};

/// `before`: what file and options said when they were last read or saved, `now` what they say now, `running` what is in use, which
/// becomes what is to be in use.
Reload merge(const Config& before, const Config& now, Config& running, Precedence precedence);

}  // namespace vdisp
