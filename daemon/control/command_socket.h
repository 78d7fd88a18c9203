// command_socket.h: the control socket and what hangs on it, in one piece for the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/control/inlet.h"

namespace vdisp {

class CommandSocket {
 public:
  /// `config` is what the stages read; it is read again where `origin` says so. `listen`: without it there is no socket. Without
  /// [control] socket a daemon that may make the socket nowhere runs without it, and tells so. Throws ControlError.
  CommandSocket(Config& config, const ConfigOrigin& origin, Inputs& inputs, bool listen, const LiveParameters::Tell& tell);

  /// Before each frame, and while one is waited for: takes what has come. `sequence` is the next frame's. True: the configuration has
  /// changed. No allocation, no wait.
  bool serve(uint64_t sequence) noexcept;
  uint64_t generation() const { return parameters_.generation(); }
  /// LiveParameters::text().
  std::string config_text() const { return parameters_.text(); }
  /// What of it counts as lost.
  void count(Health& health) const noexcept;

 private:
  LiveParameters parameters_;
  std::unique_ptr<Inlet> inlet_;
};

}  // namespace vdisp
