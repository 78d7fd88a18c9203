// shm_check.cpp: locks, leftovers, permissions and room in /tmp and /dev/shm.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/shm_check.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/sysmacros.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "ipc/endpoint.h"
#include "ipc/shm.h"

namespace vdisp {
namespace {

// 65.7 MB that iceoryx 2.0.3 takes whatever is published, and some for what else it creates.
constexpr uint64_t management_bytes = 67u << 20;

std::string user_name(uid_t uid) {
  const passwd* entry = getpwuid(uid);
  return entry ? entry->pw_name : std::to_string(uid);
}

std::string mib(uint64_t bytes) { return std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB"; }

/// "vdispd, pid 12" of the process that holds the lock on this file.
std::string lock_holder(const struct stat& file) {
  // As the kernel writes it; files of other file systems may have the same number.
  char wanted[64];
  std::snprintf(wanted, sizeof wanted, "%02x:%02x:%llu", major(file.st_dev), minor(file.st_dev),
                static_cast<unsigned long long>(file.st_ino));
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, mode, access, pid, inode;
    words >> number >> kind >> mode >> access >> pid >> inode;
    if (kind != "FLOCK" || inode != wanted) continue;
    std::string name;
    std::getline(std::ifstream("/proc/" + pid + "/comm") >> std::ws, name);
    return (name.empty() ? "a process" : name) + ", pid " + pid;
  }
  return "a process that cannot be named";
}

void refuse_taken(const struct stat& file, const std::string& path) {
  throw ShmError(69, "shared memory: taken by " + lock_holder(file) + ", which holds " + path +
                         "; one vdispd per machine, and no other iceoryx RouDi beside it: stop that one first");
}

/// A predecessor that was just killed may take a moment to let go.
void check_lock(const std::string& path) {
  for (int attempt = 0;; ++attempt) {
    const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    struct stat file {};
    if (fd < 0) {
      if (errno == ENOENT) return;
      if (lstat(path.c_str(), &file) != 0) return;
      throw ShmError(77, "shared memory: " + path + " belongs to user " + user_name(file.st_uid) +
                             " and cannot be opened; remove it, or run as that user");
    }
    fstat(fd, &file);
    const bool free = flock(fd, LOCK_EX | LOCK_NB) == 0;
    // The kernel refuses O_CREAT on another user's file in a sticky folder, even to root.
    if (free && file.st_uid != geteuid() && unlink(path.c_str()) != 0) {
      close(fd);
      throw ShmError(77, "shared memory: " + path + " belongs to user " + user_name(file.st_uid) + "; remove it");
    }
    if (!free && (attempt == 20 || probe_socket(roudi_socket) == Probe::alive)) refuse_taken(file, path);
    close(fd);
    if (free) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

void remove_leftover(const std::string& path) {
  struct stat file {};
  if (lstat(path.c_str(), &file) != 0) return;
  if (unlink(path.c_str()) == 0 || errno == ENOENT) return;
  throw ShmError(77, "shared memory: " + path + " belongs to user " + user_name(file.st_uid) + " and cannot be replaced by user " +
                         user_name(geteuid()) + "; remove it");
}

void check_writable(const char* folder) {
  if (access(folder, W_OK | X_OK) == 0) return;
  const int error = errno;
  throw ShmError(error == EROFS || error == EACCES || error == EPERM ? 77 : 71,
                 std::string("shared memory: ") + folder + ": " + std::strerror(error) + "; user " + user_name(geteuid()) +
                     " has to be able to create files there");
}

uint64_t available_memory() {
  std::ifstream info("/proc/meminfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("MemAvailable:", 0) == 0) return std::strtoull(line.c_str() + 13, nullptr, 10) << 10;
  }
  return UINT64_MAX;
}

/// iceoryx waits a minute for an answer for which it has no descriptor.
void check_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < 64)
    throw ShmError(71, "shared memory: this process may open " + std::to_string(limit.rlim_cur) + " files, needed are 64 (ulimit -n)");
}

void check_room(uint64_t needed) {
  struct statvfs shm {};
  // Readers of a daemon that died hold its memory until they notice, which takes them a moment.
  for (int attempt = 0; attempt < 20; ++attempt) {
    if (statvfs("/dev/shm", &shm) != 0) throw ShmError(71, std::string("shared memory: /dev/shm: ") + std::strerror(errno));
    if (static_cast<uint64_t>(shm.f_bavail) * shm.f_frsize >= needed) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const uint64_t room = static_cast<uint64_t>(shm.f_bavail) * shm.f_frsize;
  if (room < needed)
    throw ShmError(71, "shared memory: /dev/shm has " + mib(room) + " free of " + mib(static_cast<uint64_t>(shm.f_blocks) * shm.f_frsize) +
                           ", needed are " + mib(needed) + "; mount it larger (mount -o remount,size=...) or publish smaller images");
  const uint64_t memory = available_memory();
  if (memory < needed)
    throw ShmError(71, "shared memory: the machine has " + mib(memory) + " of memory available, needed are " + mib(needed));
}

}  // namespace

Rights rights_for(const std::string& reader_group) {
  Rights rights;
  const passwd* user = getpwuid(geteuid());
  const group* own = user ? getgrgid(user->pw_gid) : nullptr;
  if (!own)
    throw ShmError(77,
                   "shared memory: user " + std::to_string(geteuid()) + " or its group is not in the user database; iceoryx needs both");
  rights.owner_group = own->gr_name;
  if (reader_group.empty()) return rights;
  const group* readers = getgrnam(reader_group.c_str());
  if (!readers)
    throw ShmError(78,
                   "[ipc] group: there is no group '" + reader_group + "'; create it (groupadd " + reader_group + ") or leave it empty");
  rights.readers = readers->gr_gid;
  std::vector<gid_t> mine(static_cast<size_t>(std::max(0, getgroups(0, nullptr))));
  mine.resize(static_cast<size_t>(std::max(0, getgroups(static_cast<int>(mine.size()), mine.data()))));
  const bool member = rights.readers == getegid() || std::find(mine.begin(), mine.end(), rights.readers) != mine.end();
  if (geteuid() != 0 && !member)
    throw ShmError(77, "[ipc] group: user " + user_name(geteuid()) + " is not a member of '" + reader_group +
                           "' and cannot give it the stages; usermod -aG " + reader_group + " " + user_name(geteuid()));
  return rights;
}

std::vector<std::string> files_of(const Rights& rights) {
  return {roudi_socket, "/tmp/" + daemon_runtime, management_segment, "/dev/shm/" + rights.owner_group};
}

std::vector<std::string> locks() { return {"/tmp/iox-unique-roudi.lock", "/tmp/roudi.lock", "/tmp/" + daemon_runtime + ".lock"}; }

void check_shared_memory(const Rights& rights, uint64_t bytes) {
  check_descriptors();
  check_writable("/tmp");
  check_writable("/dev/shm");
  for (const std::string& lock : locks()) check_lock(lock);
  if (probe_socket(roudi_socket) == Probe::alive)
    throw ShmError(69, std::string("shared memory: ") + roudi_socket +
                           " is served by another program; one vdispd per machine, and no other iceoryx RouDi beside it");
  // Nobody alive owns these now. Removed here, so that what cannot be removed gets its message, and the memory is free again.
  for (const std::string& left : files_of(rights)) remove_leftover(left);
  check_room(management_bytes + bytes);
}

namespace {

void restrict_file(const std::string& path, const Rights& rights, mode_t with_group) {
  const bool group = rights.readers != static_cast<gid_t>(-1);
  // iceoryx lets the daemon's own group write, by an access control list: it goes, plain mode bits say it all.
  removexattr(path.c_str(), "system.posix_acl_access");
  if ((group && chown(path.c_str(), static_cast<uid_t>(-1), rights.readers) != 0) || chmod(path.c_str(), group ? with_group : 0600) != 0)
    throw ShmError(77, "shared memory: cannot set the rights of " + path + ": " + std::strerror(errno));
}

}  // namespace

void restrict_segments(const Rights& rights) {
  restrict_file("/dev/shm/" + rights.owner_group, rights, 0640);
  restrict_file(management_segment, rights, 0660);
}

void restrict_sockets(const Rights& rights) {
  restrict_file(roudi_socket, rights, 0660);
  restrict_file("/tmp/" + daemon_runtime, {rights.owner_group}, 0600);
}

}  // namespace vdisp
