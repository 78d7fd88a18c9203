// inlet.h: the control socket's end in the daemon: connections, and their messages, a bounded number at a time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "daemon/control/inputs.h"
#include "daemon/control/live_parameters.h"

namespace vdisp {

/// exit_code: 69 another daemon has the socket, 73 it cannot be made there, 77 no permission, 78 no such group. One line.
class ControlError : public std::runtime_error {
 public:
  ControlError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// Where the socket is: `configured`, or /run/vdisp/control where this user may make it, else under $XDG_RUNTIME_DIR.
/// Throws ControlError where neither is possible.
std::string control_place(const std::string& configured);

/// The socket file lives as long as this. All but the constructor is the loop's: nothing allocates, blocks or throws.
class Inlet {
 public:
  static constexpr int most_clients = 16;
  /// Told once when something goes wrong and at most once a second after: one line.
  using Tell = std::function<void(std::string_view)>;

  /// A file that a dead daemon left is replaced. `group`: whose members may connect; empty: this user only. Throws ControlError.
  Inlet(const std::string& path, const std::string& group, Inputs& inputs, LiveParameters& parameters, Tell tell);
  ~Inlet();
  Inlet(const Inlet&) = delete;
  Inlet& operator=(const Inlet&) = delete;

  const std::string& path() const { return path_; }
  /// Takes what has come: at most 32 connections and 64 messages of each client. `sequence` is the next frame's.
  void serve(uint64_t sequence) noexcept;
  /// Connections refused as all were in use, closed by the daemon, and requests refused as too many waited.
  struct Losses {
    uint64_t refused = 0, closed = 0, requests = 0;
  };
  const Losses& losses() const { return losses_; }

 private:
  struct Client {
    int socket = -1;
    uint64_t number = 0;  // of the connection, never used again
    pid_t pid = 0;
    uid_t uid = 0;
    int64_t heard_ns = 0;
    int busy_rounds = 0;  // in a row that it had more to say than is taken at a time
  };
  /// An event that may repeat faster than anybody wants to read.
  struct Edge {
    int64_t told_ns = INT64_MIN / 2;
    uint64_t untold = 0;
  };
  enum Trouble { full, wrong_message, deaf, flood, troubles };

  void lock();
  void bind_and_listen(const std::string& group);
  void accept_clients(int64_t now_ns) noexcept;
  Client* oldest_after(uint64_t number) noexcept;
  Client* free_place(int64_t now_ns) noexcept;
  void listen_to(Client& client, int64_t now_ns) noexcept;
  bool take(Client& client, const char* bytes, size_t size, int64_t now_ns) noexcept;
  void answer(Client& client, const ReplyMessage& reply) noexcept;
  void refuse(int socket, Answer answer, uint32_t number) noexcept;
  void drop(Client& client) noexcept;
  void say(Trouble trouble, const Client& client, int64_t now_ns) noexcept;

  std::string path_;
  Inputs& inputs_;
  LiveParameters& parameters_;
  Tell tell_;
  int lock_ = -1, socket_ = -1;
  uint64_t connections_ = 0;
  std::array<Client, most_clients> clients_;
  std::array<Edge, troubles> edges_;
  Losses losses_;
};

}  // namespace vdisp
