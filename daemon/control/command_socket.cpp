// command_socket.cpp: where the socket is, and what comes through it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/command_socket.h"

namespace vdisp {

CommandSocket::CommandSocket(Config& config, const std::filesystem::path& file, Inputs& inputs, const Inlet::Tell& tell) {
  std::string place;
  try {
    place = control_place(config.control.socket);
  } catch (const ControlError& error) {
    tell(std::string(error.what()) + ": no odometry comes in, and no parameter can be set");
    return;
  }
  parameters_ = std::make_unique<LiveParameters>(config, file);
  inlet_ = std::make_unique<Inlet>(place, config.ipc.group, inputs, *parameters_, tell);
}

bool CommandSocket::serve(uint64_t sequence) noexcept {
  if (!inlet_) return false;
  const uint64_t before = parameters_->generation();
  inlet_->serve(sequence);
  return parameters_->generation() != before;
}

}  // namespace vdisp
