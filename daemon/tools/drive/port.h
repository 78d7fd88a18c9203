// port.h: the serial port: opened, locked, watched, opened again. Nothing in it waits for the other side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct sp_port;

namespace vdisp::drive {

/// 8 data bits, no parity, 1 stop bit, no flow control.
class Port {
 public:
  enum class Sent {
    yes,
    later,  ///< what was sent before has not left yet: nothing is queued behind it, so that no old command comes late
    lost,   ///< the port is gone, or takes nothing for 150 ms; it is closed and fault() says why
  };

  /// `name`: device, or a link to one; "-": commands are written to standard output, a line for each.
  Port(std::string name, int baud) : name_(std::move(name)), baud_(baud) {}
  ~Port() { close(); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  const std::string& name() const { return name_; }
  bool is_output() const { return name_ == "-"; }
  bool is_open() const { return fd_ >= 0; }
  /// Opens it if it is closed and the pause since the last try is over: 0.1 s, doubled up to 2 s. True if it was opened just now.
  bool open(int64_t now_ns);
  /// The exit code of sysexits.h that the last failure of open() stands for; `EX_UNAVAILABLE` where it may pass by itself.
  int exit_code() const { return exit_code_; }
  /// Why it is not open, in one line: what was found, and what would be right.
  const std::string& fault() const { return fault_; }

  Sent send(std::string_view bytes, int64_t now_ns);
  /// What has come; 0: nothing. Closes the port where it is gone.
  size_t receive(std::span<char> to, int64_t now_ns);
  /// Waits until all has left, at most `limit_ns`.
  void drain(int64_t limit_ns);
  void close();

 private:
  bool fail(int exit_code, const std::string& why);
  bool open_at(const std::string& path);
  bool lock();
  bool configure();
  int waiting() const;
  bool hung_up() const;
  bool lose(const std::string& why, int64_t now_ns);
  bool push_rest();
  Sent print(std::string_view bytes, int64_t now_ns);

  std::string name_, fault_, rest_;  // rest_: of a command that was taken in part
  int baud_;
  sp_port* port_ = nullptr;  // null with fd_: opened without libserialport
  int fd_ = -1, exit_code_ = 0;
  int64_t retry_ns_ = 0, pause_ns_ = 0, stuck_since_ns_ = 0, opened_ns_ = 0;
};

}  // namespace vdisp::drive
