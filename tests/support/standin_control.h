// standin_control.h: a control socket whose daemon does what the test says: it hears, and answers when it is told to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "ipc/command.h"

namespace vdisp {

class StandInControl {
 public:
  explicit StandInControl(const std::string& path) : path_(path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    socket_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(socket_, 8) != 0)
      throw std::runtime_error(path + ": " + std::strerror(errno));
  }
  ~StandInControl() {
    for (const int client : clients_) close(client);
    close(socket_);
    unlink(path_.c_str());
  }
  StandInControl(const StandInControl&) = delete;
  StandInControl& operator=(const StandInControl&) = delete;

  struct Heard {
    int client;
    CommandHeader header;
    std::vector<char> bytes;
  };
  /// What came since the last call, in its order. Does not wait.
  std::vector<Heard> hear() {
    for (int client; (client = accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0;) clients_.push_back(client);
    std::vector<Heard> all;
    for (const int client : clients_) {
      Heard one{client, {}, std::vector<char>(512)};
      for (ssize_t size; (size = recv(client, one.bytes.data(), one.bytes.size(), 0)) >= static_cast<ssize_t>(sizeof one.header);) {
        std::memcpy(&one.header, one.bytes.data(), sizeof one.header);
        all.push_back(one);
      }
    }
    return all;
  }
  /// The same, of one kind.
  int count(CommandType type) {
    int found = 0;
    for (const Heard& heard : hear()) found += heard.header.type == type;
    return found;
  }
  void answer(const Heard& heard, ReplyMessage reply) {
    reply.header.magic = command_magic;
    reply.header.version = command_version;
    reply.header.number = heard.header.number;
    send(heard.client, &reply, sizeof reply, MSG_NOSIGNAL);
  }

 private:
  std::string path_;
  int socket_ = -1;
  std::vector<int> clients_;
};

}  // namespace vdisp
