// roudi.cpp: keeps the list of readers and asks the kernel who is still there.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/roudi.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <vector>

#include "ipc/endpoint.h"

namespace vdisp {
namespace {

// The base class starts its thread before the members below exist; zero until they do.
std::atomic<bool> ready{false};

bool gone(const std::string& name, int pid) {
  const Probe probe = probe_socket("/tmp/" + name);
  if (probe == Probe::nobody) return true;
  return probe == Probe::absent && kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace

EmbeddedRoudi::EmbeddedRoudi(iox::roudi::RouDiMemoryInterface& memory, iox::roudi::PortManager& ports)
    : RouDi(memory, ports, RoudiStartupParameters{iox::roudi::MonitoringMode::OFF, false, RuntimeMessagesThreadStart::DEFER_START}) {
  ready = true;
  startProcessRuntimeMessagesThread();
}

void EmbeddedRoudi::processMessage(const iox::runtime::IpcMessage& message, const iox::runtime::IpcMessageType& command,
                                   const iox::RuntimeName_t& name) noexcept {
  const std::string client(name.c_str());
  if (command == iox::runtime::IpcMessageType::REG && message.getNumberOfElements() == 6) {
    const std::lock_guard lock(mutex_);
    clients_[client] = std::atoi(message.getElementAtIndex(2).c_str());
  } else if (command == iox::runtime::IpcMessageType::TERMINATION) {
    const std::lock_guard lock(mutex_);
    clients_.erase(client);
  }
  RouDi::processMessage(message, command, name);
}

void EmbeddedRoudi::cyclicUpdateHook() noexcept {
  if (!ready) return;
  std::vector<std::string> dead;
  {
    const std::lock_guard lock(mutex_);
    for (auto client = clients_.begin(); client != clients_.end();) {
      if (gone(client->first, client->second)) {
        dead.push_back(client->first);
        client = clients_.erase(client);
      } else {
        ++client;
      }
    }
  }
  for (const std::string& name : dead) {
    const auto command = iox::runtime::IpcMessageType::TERMINATION;
    const iox::runtime::IpcMessage message({iox::runtime::IpcMessageTypeToString(command), name});
    RouDi::processMessage(message, command, iox::RuntimeName_t(iox::cxx::TruncateToCapacity, name));
    unlink(("/tmp/" + name).c_str());  // in a sticky /tmp only where it is ours
  }
}

}  // namespace vdisp
