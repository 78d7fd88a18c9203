// endpoint.h: Unix sockets as iceoryx uses them: who listens, and may we talk to it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <string>

namespace vdisp {

inline constexpr const char* roudi_socket = "/tmp/roudi";
inline constexpr const char* management_segment = "/dev/shm/iceoryx_mgmt";

enum class Probe { alive, absent, nobody, forbidden, failed };

sockaddr_un socket_address(const std::string& path);
/// nobody: the file is there, its owner is dead.
Probe probe_socket(const std::string& path);
/// Removes sockets in /tmp whose names begin like this and that nobody owns any more.
void remove_dead_sockets(const std::string& prefix);

}  // namespace vdisp
