// config_origin.h: where a configuration is from, and who asks for another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdisp {

/// Where the configuration came from.
struct ConfigOrigin {
  std::filesystem::path file;        ///< what save writes to, and what is read again; empty: there is none
  std::vector<std::string> options;  ///< SECTION.KEY=VALUE of the command line: they go before the file, then too
  bool watched = false;              ///< a changed file is read again; SIGHUP has it read again always
};

/// Who asks.
struct Sender {
  uint64_t connection = 0;  ///< number of the connection; 0: nobody waits for the answer
  pid_t pid = 0;
  uid_t uid = 0;
};

}  // namespace vdisp
