// roudi.h: RouDi inside the daemon; gives back what readers held that are gone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <iceoryx_posh/internal/roudi/roudi.hpp>
#include <map>
#include <mutex>

namespace vdisp {

/// iceoryx's own monitoring removes a reader that was silent for 1.5 s. One that was only stopped (SIGSTOP, a debugger, starved
/// by a real-time thread) comes back to memory that is no longer its own, and corrupts it. So monitoring is off, and a reader is
/// removed when the kernel says that nobody owns its socket any more: dead for certain, and noticed within 0.3 s.
class EmbeddedRoudi final : public iox::roudi::RouDi {
 public:
  EmbeddedRoudi(iox::roudi::RouDiMemoryInterface& memory, iox::roudi::PortManager& ports);

  /// Asks its own message thread, by the socket that a new reader would use. No wait; from one thread.
  void ask() noexcept;
  /// How long ago both threads were last seen at work: the one that answers, when a question of ask() reached it, and the one that keeps
  /// the list, which stands still when its lock is never given back.
  int64_t silence_ns() const noexcept;

 private:
  void processMessage(const iox::runtime::IpcMessage& message, const iox::runtime::IpcMessageType& command,
                      const iox::RuntimeName_t& name) noexcept override;
  void cyclicUpdateHook() noexcept override;

  std::atomic<int64_t> answered_ns_, cycled_ns_;  // CLOCK_MONOTONIC
  std::mutex mutex_;
  std::map<std::string, int> clients_;  // name -> pid, as it registered
};

}  // namespace vdisp
