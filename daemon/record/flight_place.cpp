// flight_place.cpp: tries it as the flight recorder will: with the rights of this process, in its sandbox.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/flight_place.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace vdisp {

std::string trouble_with_flight_place(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  int found = error.value();
  if (!found && access(folder.c_str(), W_OK | X_OK) != 0) found = errno;
  if (!found && !std::filesystem::is_directory(folder, error)) found = ENOTDIR;
  if (!found) return {};
  return folder.string() + ": cannot be written (" + std::strerror(found) +
         "): the flight recorder will not keep what happens; [recorder] folder must be one of this user's, and under systemd one that "
         "ReadWritePaths opens";
}

}  // namespace vdisp
