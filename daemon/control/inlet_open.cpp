// inlet_open.cpp: where the control socket is, whose it is, and what may be replaced.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sysexits.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "daemon/control/inlet.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr int backlog = 64;

[[noreturn]] void fail(const std::string& path, const char* what, int error) {
  const bool forbidden = error == EACCES || error == EPERM || error == EROFS;
  throw ControlError(forbidden ? EX_NOPERM : EX_CANTCREAT,
                     "control socket " + path + ": " + what + ": " + std::strerror(error) + "; [control] socket names another place");
}

/// The folder is made where it is missing, for all to enter: the socket's own mode says who may connect.
bool can_make(const fs::path& path, mode_t mode) {
  const fs::path folder = path.parent_path();
  if (mkdir(folder.c_str(), mode) == 0) chmod(folder.c_str(), mode);
  return access(folder.c_str(), W_OK | X_OK) == 0;
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw ControlError(EX_CONFIG, "control socket " + path + ": the path has " + std::to_string(path.size()) +
                                      " bytes, must have at most " + std::to_string(sizeof address.sun_path - 1) + " ([control] socket)");
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

/// Somebody listens there who has no lock: not one of ours.
bool answers(const sockaddr_un& address) {
  const int probe = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool refused = connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 && errno == ECONNREFUSED;
  close(probe);
  return !refused;
}

}  // namespace

std::string control_place(const std::string& configured) {
  if (!configured.empty()) return configured;
  if (can_make(system_control_socket, 0755)) return system_control_socket;
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime && can_make(fs::path(runtime) / user_control_socket, 0700)) return fs::path(runtime) / user_control_socket;
  throw ControlError(EX_NOPERM, std::string("control socket: this user may not make ") + system_control_socket + ", and " +
                                    (runtime && *runtime ? "$XDG_RUNTIME_DIR cannot be written" : "$XDG_RUNTIME_DIR is not set") +
                                    "; [control] socket names another place");
}

Inlet::Inlet(const std::string& path, const std::string& group, Inputs& inputs, LiveParameters& parameters, Tell tell)
    : path_(path), inputs_(inputs), parameters_(parameters), tell_(std::move(tell)) {
  try {
    lock();
    bind_and_listen(group);
  } catch (...) {
    if (socket_ >= 0) close(socket_);
    if (lock_ >= 0) close(lock_);
    throw;
  }
}

Inlet::~Inlet() {
  for (Client& client : clients_)
    if (client.socket >= 0) close(client.socket);
  unlink(path_.c_str());
  close(socket_);
  close(lock_);  // the file stays: removing it would let two daemons hold two locks of one name
}

/// Who has the lock owns the socket file, whatever the state it is in.
void Inlet::lock() {
  const std::string file = path_ + ".lock";
  lock_ = open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (lock_ < 0) fail(path_, "its lock cannot be made", errno);
  if (flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
  if (errno != EWOULDBLOCK) fail(path_, "its lock cannot be taken", errno);
  throw ControlError(EX_UNAVAILABLE,
                     "control socket " + path_ + ": another vdispd uses it; end that one, or name another [control] socket");
}

void Inlet::bind_and_listen(const std::string& group) {
  const sockaddr_un address = address_of(path_);
  struct stat found {};
  if (lstat(path_.c_str(), &found) == 0) {
    if (!S_ISSOCK(found.st_mode))
      throw ControlError(EX_CANTCREAT,
                         "control socket " + path_ + ": a file that is no socket stands there; remove it, or name another place");
    if (answers(address))
      throw ControlError(EX_UNAVAILABLE,
                         "control socket " + path_ + ": another program listens there; end it, or name another [control] socket");
    unlink(path_.c_str());
  }
  gid_t readers = static_cast<gid_t>(-1);
  if (!group.empty()) {
    const struct group* entry = getgrnam(group.c_str());
    if (!entry)
      throw ControlError(EX_CONFIG, "[ipc] group: there is no group '" + group + "'; create it (groupadd " + group + ") or leave it empty");
    readers = entry->gr_gid;
  }
  socket_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) fail(path_, "no socket", errno);
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fail(path_, "cannot be made", errno);
  // Nobody can connect before listen(): the rights are right from the first moment.
  const bool rights = chmod(path_.c_str(), 0600) == 0 &&
                      (group.empty() || (chown(path_.c_str(), static_cast<uid_t>(-1), readers) == 0 && chmod(path_.c_str(), 0660) == 0));
  if (!rights || listen(socket_, backlog) != 0) {
    const int error = errno;
    unlink(path_.c_str());
    fail(path_, rights ? "cannot listen" : "cannot be given to [ipc] group", error);
  }
}

}  // namespace vdisp
