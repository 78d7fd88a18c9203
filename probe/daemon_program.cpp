// daemon_program.cpp: a build tree has its own beside the probe, an installed system has both on the PATH.
// SPDX-License-Identifier: Apache-2.0
#include "probe/daemon_program.h"

#include <unistd.h>

#include <filesystem>

namespace vdisp {

std::string daemon_program() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path beside = fs::read_symlink("/proc/self/exe", error).parent_path() / "vdispd";
  // A folder of that name may be "executed" too.
  return !error && fs::is_regular_file(beside, error) && access(beside.c_str(), X_OK) == 0 ? beside.string() : "vdispd";
}

}  // namespace vdisp
