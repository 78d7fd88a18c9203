// options.h: the command line of vdispd.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"

namespace vdisp {

struct Options {
  Config config;
  std::string file;          ///< the vdisp.cfg it was read from; empty: none
  std::string dump;          ///< folder; empty: none
  std::string record;        ///< folder; empty: none
  std::string dot;           ///< file; empty: none
  std::string cpu = "auto";  ///< a level of kernels::levels(), or auto
  uint64_t frames = 0;       ///< 0: until the source ends
};

/// Reads the command line and the configuration it names. When there is nothing to run (help, a mistake, --check-config,
/// --print-config) it has said so and returns the exit code instead.
struct Parsed {
  Options options;
  std::optional<int> exit_code;
};
Parsed parse_options(int argc, char** argv);

}  // namespace vdisp
