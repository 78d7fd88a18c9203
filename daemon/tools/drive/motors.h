// motors.h: orders in, commands out: at a fixed rate, within limits, and a stop at once whenever anything is not as it should be.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "daemon/tools/drive/orders.h"
#include "daemon/tools/drive/port.h"
#include "daemon/tools/drive/replies.h"
#include "daemon/tools/drive/settings.h"
#include "daemon/tools/drive/wheels.h"

namespace vdisp::drive {

/// Since the start.
struct Tally {
  uint64_t commands = 0, late = 0;        ///< sent; more than one and a half periods after the one before
  std::array<uint64_t, halts> stopped{};  ///< times that each Halt began
  uint64_t port_opened = 0, port_lost = 0;
  int64_t longest_gap_ns = 0;  ///< between two commands while the port is open
};

class Motors {
 public:
  /// The settings have to outlive it.
  explicit Motors(const Settings& settings);
  /// Stops.
  ~Motors();
  Motors(const Motors&) = delete;
  Motors& operator=(const Motors&) = delete;

  /// Opens the port if it is time for it, reads replies, and sends what is due. To be called at next_ns() or earlier. `order` as it is now;
  /// `ending`: no more order counts.
  void serve(const Order& order, bool ending, int64_t now_ns);
  int64_t next_ns() const { return due_ns_; }
  /// Why they stand; none: they are driven.
  Halt halt() const { return halt_; }
  /// Told to stop, and at a stand as far as can be told by commands.
  bool standing() const { return stops_due_ == 0; }
  /// Says stop once more and lets it leave; at most 0.1 s.
  void finish();

  const Port& port() const { return port_; }
  const Replies& replies() const { return replies_; }
  const Tally& tally() const { return tally_; }
  const Wheels& wheels() const { return ramp_.now(); }

 private:
  Halt judge(const Order& order, bool ending, int64_t now_ns);
  void look(const Order& order, bool ending, int64_t now_ns);
  void read(int64_t now_ns);
  bool say(const Phrase& phrase, const Motion& motion, int64_t now_ns);
  void command(const Order& order, int64_t now_ns);
  void count(int64_t now_ns);

  const Settings& settings_;
  Port port_;
  Replies replies_;
  Ramp ramp_;
  Halt halt_ = Halt::dead;
  bool started_ = false;
  int stops_due_ = 0;  ///< stops that are still to be said before they can be taken for heard
  int64_t due_ns_ = 0, sent_ns_ = 0;
  Tally tally_;
};

}  // namespace vdisp::drive
