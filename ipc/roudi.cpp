// roudi.cpp: keeps the list of readers and asks the kernel who is still there.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/roudi.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "ipc/endpoint.h"

namespace vdisp {
namespace {

// The base class starts its thread before the members below exist; zero until they do.
std::atomic<bool> ready{false};

// What ask() says; no reader's runtime has this name.
constexpr const char* self = "vdispd-asks-itself";

int64_t now_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

bool gone(const std::string& name, int pid) {
  const Probe probe = probe_socket("/tmp/" + name);
  if (probe == Probe::nobody) return true;
  return probe == Probe::absent && kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace

EmbeddedRoudi::EmbeddedRoudi(iox::roudi::RouDiMemoryInterface& memory, iox::roudi::PortManager& ports)
    : RouDi(memory, ports, RoudiStartupParameters{iox::roudi::MonitoringMode::OFF, false, RuntimeMessagesThreadStart::DEFER_START}) {
  answered_ns_ = cycled_ns_ = now_ns();
  ready = true;
  startProcessRuntimeMessagesThread();
}

void EmbeddedRoudi::processMessage(const iox::runtime::IpcMessage& message, const iox::runtime::IpcMessageType& command,
                                   const iox::RuntimeName_t& name) noexcept {
  const std::string client(name.c_str());
  if (client == self) {
    answered_ns_ = now_ns();
    return;
  }
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
  cycled_ns_ = now_ns();
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

void EmbeddedRoudi::ask() noexcept {
  const int out = socket(AF_LOCAL, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (out < 0) return;
  static const std::string question = [] {
    const iox::runtime::IpcMessage message({iox::runtime::IpcMessageTypeToString(iox::runtime::IpcMessageType::KEEPALIVE), self});
    return message.getMessage();
  }();
  const sockaddr_un address = socket_address(roudi_socket);
  // Not sent, as the queue is full or the file gone: then there is no answer, and that is the answer.
  (void)sendto(out, question.c_str(), question.size() + 1, MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  close(out);
}

int64_t EmbeddedRoudi::silence_ns() const noexcept { return now_ns() - std::min(answered_ns_.load(), cycled_ns_.load()); }

}  // namespace vdisp
