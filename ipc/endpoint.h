// endpoint.h: Unix sockets as iceoryx uses them: who listens, and may we talk to it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace vdisp {

inline constexpr const char* roudi_socket = "/tmp/roudi";
inline constexpr const char* management_segment = "/dev/shm/iceoryx_mgmt";

enum class Probe { alive, absent, nobody, forbidden, failed };

inline sockaddr_un socket_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_LOCAL;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  return address;
}

/// nobody: the file is there, its owner is dead.
inline Probe probe_socket(const std::string& path) {
  const int socket_fd = socket(AF_LOCAL, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_fd < 0) return Probe::failed;
  const sockaddr_un address = socket_address(path);
  const int error = connect(socket_fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
  close(socket_fd);
  switch (error) {
    case 0: return Probe::alive;
    case ENOENT: return Probe::absent;
    case ECONNREFUSED: return Probe::nobody;
    case EACCES:
    case EPERM: return Probe::forbidden;
    default: return Probe::failed;
  }
}

}  // namespace vdisp
