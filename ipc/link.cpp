// link.cpp: the messages, the mappings, the permissions.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/link.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <iceoryx_posh/iceoryx_posh_types.hpp>
#include <iceoryx_posh/internal/mepoo/segment_manager.hpp>
#include <iceoryx_posh/internal/runtime/ipc_interface_base.hpp>
#include <iceoryx_posh/internal/runtime/ipc_message.hpp>
#include <iceoryx_posh/runtime/port_config_info.hpp>
#include <iceoryx_posh/version/version_info.hpp>

#include "ipc/endpoint.h"
#include "ipc/quiet.h"

namespace vdisp {
namespace {

using iox::rp::BaseRelativePointer;
using iox::runtime::IpcMessage;
using iox::runtime::IpcMessageType;

constexpr int64_t answer_ns = 1'000'000'000;  // after this a daemon does not answer
constexpr int64_t retry_ns = 20'000'000;

std::string word(IpcMessageType type) { return iox::runtime::IpcMessageTypeToString(type); }

uint64_t number(const IpcMessage& message, uint32_t index) { return std::strtoull(message.getElementAtIndex(index).c_str(), nullptr, 10); }

std::string user_name(uid_t uid) {
  const passwd* entry = getpwuid(uid);
  return entry ? entry->pw_name : std::to_string(uid);
}

std::string not_permitted(const std::string& path) {
  struct stat file {};
  const std::string me = user_name(geteuid());
  if (stat(path.c_str(), &file) != 0) return path + " is not accessible for user " + me;
  const group* readers = (file.st_mode & S_IRGRP) ? getgrgid(file.st_gid) : nullptr;
  const std::string text = "user " + me + " may not read what vdispd publishes (" + path + "): ";
  if (!readers) return text + "only its own user " + user_name(file.st_uid) + " may; set [ipc] group in vdisp.cfg";
  return text + "it has to be a member of group " + readers->gr_name + " (usermod -aG " + readers->gr_name + " " + me +
         ", then log in again)";
}

std::string not_taken(int error) {
  const bool full = error == EAGAIN || error == ENOBUFS;
  return full ? "vdispd does not take messages: it hangs or is stopped" : "vdispd has just ended";
}

}  // namespace

Link::Link() {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  // In a container the pid alone is not unique.
  name_ = "vdisp-" + std::to_string(getuid()) + "-" + std::to_string(getpid()) + "-" + std::to_string(now.tv_nsec / 1000);
  stamp_ = now.tv_sec * 1'000'000 + now.tv_nsec / 1000;
}

Link::~Link() {
  if (up()) send((IpcMessage() << word(IpcMessageType::TERMINATION) << name_).getMessage());
  drop("closed");
  if (socket_ >= 0) {
    close(socket_);
    unlink(("/tmp/" + name_).c_str());
  }
}

bool Link::fail(Connection kind, const std::string& message) {
  drop(message);
  failure_ = kind;
  return false;
}

void Link::drop(const std::string& why) {
  unmap(images_);
  unmap(management_);
  if (roudi_ >= 0) close(roudi_);
  roudi_ = -1;
  phase_ = Phase::down;
  asked_ns_ = 0;
  failure_ = Connection::no_daemon;
  message_ = why;
}

bool Link::bind_socket() {
  if (socket_ >= 0) return true;
  // A daemon of another user cannot remove what our dead left in a sticky /tmp.
  remove_dead_sockets("vdisp-" + std::to_string(getuid()) + "-");
  socket_ = socket(AF_LOCAL, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const std::string path = "/tmp/" + name_;
  const sockaddr_un address = socket_address(path);
  if (socket_ >= 0 && bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return true;
  const int error = errno;
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  return fail(error == EACCES || error == EROFS || error == EPERM ? Connection::no_permission : Connection::no_memory,
              "cannot make the socket " + path + ": " + std::strerror(error));
}

bool Link::open_roudi() {
  struct stat file {};
  const std::string none = "no vdispd is running on this machine (nobody serves " + std::string(roudi_socket) + "); start it";
  roudi_ = socket(AF_LOCAL, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (roudi_ < 0) return fail(Connection::no_memory, std::string("cannot make a socket: ") + std::strerror(errno));
  const sockaddr_un address = socket_address(roudi_socket);
  if (connect(roudi_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno != EACCES && errno != EPERM) return fail(Connection::no_daemon, none);
    timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    // RouDi makes the socket before the daemon can hand it to the readers. A socket from the future is one from before the clock was
    // stepped.
    const bool starting = stat(roudi_socket, &file) == 0 && now.tv_sec >= file.st_ctime && now.tv_sec - file.st_ctime < 2;
    return fail(starting ? Connection::no_daemon : Connection::no_permission,
                starting ? "vdispd is starting" : not_permitted(roudi_socket));
  }
  const int fd = open(management_segment, O_RDWR | O_CLOEXEC);
  if (fd < 0 && errno == ENOENT) return fail(Connection::no_daemon, none);
  if (fd < 0 && errno == EACCES) return fail(Connection::no_permission, not_permitted(management_segment));
  if (fd < 0) return fail(Connection::no_memory, std::string("cannot open ") + management_segment + ": " + std::strerror(errno));
  fstat(fd, &file);
  inode_ = file.st_ino;
  owner_ = file.st_uid;
  const bool mapped = map(management_, fd, static_cast<uint64_t>(file.st_size), 0, true);
  close(fd);
  if (!mapped) return fail(Connection::no_memory, std::string("cannot map iceoryx's management memory: ") + std::strerror(errno));
  // The daemon answers to our socket: it has to be allowed to.
  const std::string own = "/tmp/" + name_;
  const bool given = geteuid() == owner_                                            ? chmod(own.c_str(), 0600) == 0
                     : geteuid() == 0                                               ? chown(own.c_str(), owner_, file.st_gid) == 0
                     : chown(own.c_str(), static_cast<uid_t>(-1), file.st_gid) == 0 ? chmod(own.c_str(), 0660) == 0
                                                                                    : owner_ == 0;
  return given || fail(Connection::no_permission, not_permitted(management_segment));
}

bool Link::advance(int64_t now_ns) {
  if (phase_ == Phase::up) return true;
  if (phase_ == Phase::registering) {
    for (std::string answer = receive(); !answer.empty(); answer = receive()) {
      if (registered(answer)) return true;
      if (phase_ == Phase::down) return false;
    }
    unanswered_ = now_ns - asked_ns_ > answer_ns;
    if (unanswered_)
      return fail(Connection::no_daemon,
                  std::string("the program behind ") + roudi_socket + " does not answer: vdispd hangs or is stopped");
    return false;
  }
  if (now_ns < retry_ns_) return false;
  retry_ns_ = now_ns + retry_ns;
  const Muted muted;
  if (!bind_socket() || !open_roudi()) return false;
  while (!receive().empty()) {
  }
  const auto version = static_cast<iox::cxx::Serialization>(iox::version::VersionInfo::getCurrentVersion());
  const IpcMessage request = IpcMessage() << word(IpcMessageType::REG) << name_ << std::to_string(getpid()) << std::to_string(getuid())
                                          << std::to_string(++stamp_) << version.toString();
  if (!send(request.getMessage())) return fail(Connection::no_daemon, not_taken(errno));
  phase_ = Phase::registering;
  asked_ns_ = now_ns;
  if (!unanswered_) message_ = "vdispd is there and has not answered yet";
  return false;
}

bool Link::registered(const std::string& text) {
  const Muted muted;
  const IpcMessage answer(text);
  if (answer.getNumberOfElements() != 5 || answer.getElementAtIndex(0) != word(IpcMessageType::REG_ACK)) return false;
  if (number(answer, 3) != static_cast<uint64_t>(stamp_)) return false;  // an answer to a question given up before
  const uint64_t offset = number(answer, 2);
  const uint64_t segment = number(answer, 4);
  if (number(answer, 1) > management_.bytes || offset >= management_.bytes || !alive())
    return fail(Connection::no_daemon, "vdispd was restarted just now");
  management_.segment = segment;
  management_.registered = BaseRelativePointer::registerPtr(segment, management_.memory, management_.bytes);
  if (!management_.registered)
    return fail(Connection::no_memory, "this process has another vdisp client or iceoryx runtime; one per process");
  if (!map_images(offset)) return false;
  phase_ = Phase::up;
  unanswered_ = false;
  asked_ns_ = 0;
  failure_ = Connection::connected;
  message_ = "connected";
  return true;
}

bool Link::map_images(uint64_t manager_offset) {
  auto* manager = reinterpret_cast<iox::mepoo::SegmentManager<>*>(management_.memory + manager_offset);
  // Asked as the daemon's user, which always has the segment; whether we may open it the kernel decides.
  const auto segments = manager->getSegmentMappings(iox::posix::PosixUser{owner_});
  if (segments.empty()) return fail(Connection::no_daemon, "the RouDi that is running has no segment for images: it is not vdispd's");
  const std::string path = std::string("/dev/shm/") + segments.front().m_sharedMemoryName.c_str();
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    return errno == EACCES ? fail(Connection::no_permission, not_permitted(path))
                           : fail(Connection::no_daemon, path + ": " + std::strerror(errno));
  struct stat file {};
  const bool mapped = fstat(fd, &file) == 0 && static_cast<uint64_t>(file.st_size) >= segments.front().m_size &&
                      map(images_, fd, segments.front().m_size, segments.front().m_segmentId, false);
  close(fd);
  if (!mapped) return fail(Connection::no_memory, "cannot map " + path + ": " + std::strerror(errno));
  images_.registered = BaseRelativePointer::registerPtr(images_.segment, images_.memory, images_.bytes);
  return images_.registered || fail(Connection::no_memory, "this process has another vdisp client or iceoryx runtime; one per process");
}

bool Link::map(Mapping& mapping, int fd, uint64_t bytes, uint64_t segment, bool writable) {
  // Populated: a reader that is killed between popping a block and noting it loses the block, and page faults make that moment long.
  const int protection = writable ? PROT_READ | PROT_WRITE : PROT_READ;
  void* memory = bytes == 0 ? MAP_FAILED : mmap(nullptr, bytes, protection, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (memory == MAP_FAILED) return false;
  mapping = {static_cast<uint8_t*>(memory), bytes, segment, false};
  return true;
}

void Link::unmap(Mapping& mapping) {
  if (mapping.registered) BaseRelativePointer::unregisterPtr(mapping.segment);
  if (mapping.memory) munmap(mapping.memory, mapping.bytes);
  mapping = {};
}

bool Link::alive() const {
  struct stat file {};
  const Probe probe = probe_socket(roudi_socket);  // failed: we are out of descriptors, which says nothing about the daemon
  return (probe == Probe::alive || probe == Probe::failed) && stat(management_segment, &file) == 0 && file.st_ino == inode_;
}

bool Link::send(const std::string& message) { return ::send(roudi_, message.c_str(), message.size() + 1, MSG_DONTWAIT | MSG_NOSIGNAL) > 0; }

std::string Link::receive() {
  std::array<char, 4096> text;
  const ssize_t size = recv(socket_, text.data(), text.size() - 1, MSG_DONTWAIT);
  if (size <= 0) return {};
  text[static_cast<size_t>(size)] = 0;
  return text.data();
}

void Link::ask_port(const std::string& instance, const std::string& topic, int64_t now_ns) {
  const Muted muted;
  const auto text = [](const std::string& s) { return iox::capro::IdString_t(iox::cxx::TruncateToCapacity, s); };
  const iox::capro::ServiceDescription service{"vdisp", text(instance), text(topic)};
  iox::popo::SubscriberOptions options;  // DISCARD_OLDEST is the default
  options.queueCapacity = 2;
  options.historyRequest = 1;
  options.nodeName = iox::NodeName_t(iox::cxx::TruncateToCapacity, name_);
  const IpcMessage request = IpcMessage() << word(IpcMessageType::CREATE_SUBSCRIBER) << name_
                                          << static_cast<iox::cxx::Serialization>(service).toString() << options.serialize().toString()
                                          << static_cast<iox::cxx::Serialization>(iox::runtime::PortConfigInfo()).toString();
  if (send(request.getMessage()))
    asked_ns_ = now_ns;
  else
    drop(not_taken(errno));
}

std::optional<Link::Port> Link::port(int64_t now_ns) {
  if (!busy()) return {};
  const std::string text = receive();
  if (text.empty()) {
    if (now_ns - asked_ns_ > answer_ns) drop("vdispd does not answer: it hangs or is stopped");
    return {};
  }
  const IpcMessage answer(text);
  asked_ns_ = 0;
  failure_ = Connection::connected;
  if (answer.getNumberOfElements() == 3 && answer.getElementAtIndex(0) == word(IpcMessageType::CREATE_SUBSCRIBER_ACK)) {
    const uint64_t offset = number(answer, 1);
    if (number(answer, 2) == management_.segment && offset + sizeof(Port::MemberType_t) <= management_.bytes)
      return Port(reinterpret_cast<Port::MemberType_t*>(management_.memory + offset));
    drop("vdispd sent what this version does not understand");
    return {};
  }
  failure_ = Connection::no_memory;
  message_ = "vdispd has no room for one more reader (1024 subscriptions on a machine)";
  return {};
}

bool Link::holds(const void* memory, uint64_t bytes) const {
  const auto* at = static_cast<const uint8_t*>(memory);
  return images_.memory && at >= images_.memory && bytes <= images_.bytes && at + bytes <= images_.memory + images_.bytes;
}

}  // namespace vdisp
