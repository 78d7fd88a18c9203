// link.h: a reader's side of iceoryx: registration, mappings, subscriber ports. Nothing in it waits, throws or aborts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <iceoryx_posh/internal/popo/ports/subscriber_port_user.hpp>
#include <optional>
#include <string>

#include "ipc/include/vdisp/client.h"

namespace vdisp {

/// Instead of iceoryx's runtime, which blocks for a minute or aborts where there is no RouDi, a stale lock or no permission. It
/// speaks the same messages: REG, CREATE_SUBSCRIBER, TERMINATION. It takes no lock in shared memory: whatever happens to this
/// process, the daemon never waits for it.
class Link {
 public:
  using Port = iox::popo::SubscriberPortUser;

  Link();
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// One step towards a connection; true once there is one. Else failure() and message() say what is missing.
  bool advance(int64_t now_ns);
  bool up() const { return phase_ == Phase::up; }
  bool registering() const { return phase_ == Phase::registering; }
  /// False when the daemon that was connected is gone. Two system calls.
  bool alive() const;
  /// Gives up the connection; all ports and images are gone with it.
  void drop(const std::string& why);

  Connection failure() const { return failure_; }
  const std::string& message() const { return message_; }

  /// Asks for a port; one at a time. True while the answer is awaited.
  bool busy() const { return asked_ns_ != 0; }
  void ask_port(const std::string& instance, const std::string& topic, int64_t now_ns);
  /// The port, once it has come; nothing while it is awaited or has been refused (then busy() is false). No answer drops the
  /// link.
  std::optional<Port> port(int64_t now_ns);
  /// True where these bytes lie in the images.
  bool holds(const void* memory, uint64_t bytes) const;

 private:
  enum class Phase { down, registering, up };
  struct Mapping {
    uint8_t* memory = nullptr;
    uint64_t bytes = 0, segment = 0;
    bool registered = false;
  };
  bool fail(Connection kind, const std::string& message);
  bool bind_socket();
  bool open_roudi();
  bool send(const std::string& message);
  std::string receive();
  bool registered(const std::string& answer);
  bool map(Mapping& mapping, int fd, uint64_t bytes, uint64_t segment, bool writable);
  void unmap(Mapping& mapping);
  bool map_images(uint64_t manager_offset);

  Phase phase_ = Phase::down;
  Connection failure_ = Connection::no_daemon;
  std::string message_ = "not connected yet", name_;
  int socket_ = -1, roudi_ = -1;
  int64_t stamp_ = 0, asked_ns_ = 0, retry_ns_ = 0;
  uint64_t inode_ = 0;
  bool unanswered_ = false;  // the last question; said until there is an answer
  uint32_t owner_ = 0;
  Mapping management_, images_;
};

}  // namespace vdisp
