// command_socket.cpp: where the socket is, and what comes through it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/command_socket.h"

namespace vdisp {

CommandSocket::CommandSocket(Config& config, const ConfigOrigin& origin, Inputs& inputs, bool listen, const LiveParameters::Tell& tell)
    : parameters_(config, origin, tell) {
  if (!listen) return;
  std::string place;
  try {
    place = control_place(config.control.socket);
  } catch (const ControlError& error) {
    tell(std::string(error.what()) + ": no odometry comes in, and no parameter can be set", true);
    return;
  }
  inlet_ = std::make_unique<Inlet>(place, config.ipc.group, inputs, parameters_, [tell](std::string_view line) { tell(line, true); });
}

bool CommandSocket::serve(uint64_t sequence) noexcept {
  const uint64_t before = parameters_.generation();
  LiveParameters::Reply reply;
  if (inlet_) {
    inlet_->serve(sequence);
  } else {
    while (parameters_.next(reply)) parameters_.done();
  }
  return parameters_.generation() != before;
}

void CommandSocket::count(Health& health) const noexcept {
  health.reloads = parameters_.reloads();
  health.reloads_refused = parameters_.reloads_refused();
  if (!inlet_) return;
  health.connections_refused = inlet_->losses().refused;
  health.connections_closed = inlet_->losses().closed;
  health.requests_refused = inlet_->losses().requests;
}

}  // namespace vdisp
