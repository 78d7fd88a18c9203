// command_socket.h: the control socket and what hangs on it, in one piece for the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/control/inlet.h"

namespace vdisp {

class CommandSocket {
 public:
  /// `config` is what the stages read, `file` the vdisp.cfg it came from (empty: none). Without [control] socket a daemon that may make
  /// the socket nowhere runs without it, and tells so. Throws ControlError.
  CommandSocket(Config& config, const std::filesystem::path& file, Inputs& inputs, const Inlet::Tell& tell);

  /// Before each frame, and while one is waited for: takes what has come. `sequence` is the next frame's. True: the configuration has
  /// changed. No allocation, no wait.
  bool serve(uint64_t sequence) noexcept;
  uint64_t generation() const { return parameters_ ? parameters_->generation() : 0; }

 private:
  std::unique_ptr<LiveParameters> parameters_;
  std::unique_ptr<Inlet> inlet_;
};

}  // namespace vdisp
