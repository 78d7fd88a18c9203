// endpoint.cpp: asks the kernel who owns a socket.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/endpoint.h"

#include <dirent.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace vdisp {

sockaddr_un socket_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_LOCAL;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  return address;
}

Probe probe_socket(const std::string& path) {
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

void remove_dead_sockets(const std::string& prefix) {
  DIR* folder = opendir("/tmp");
  if (!folder) return;
  while (const dirent* entry = readdir(folder)) {
    const std::string path = std::string("/tmp/") + entry->d_name;
    if (entry->d_type == DT_SOCK && path.rfind("/tmp/" + prefix, 0) == 0 && probe_socket(path) == Probe::nobody) unlink(path.c_str());
  }
  closedir(folder);
}

}  // namespace vdisp
