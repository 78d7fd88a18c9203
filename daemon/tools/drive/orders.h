// orders.h: what the daemon says the rover is to do, and whether it may be done.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "ipc/include/vdisp/client.h"

namespace vdisp::drive {

/// Why the motors stand. Ordered by where one looks first.
enum class Halt : uint32_t {
  none = 0,   ///< they do what is ordered
  ending,     ///< this program was told to end
  no_port,    ///< the serial port is not there
  dead,       ///< no daemon, or it hangs
  stale,      ///< no order, or none for [drive] timeout
  over,       ///< the order said until when, and that was
  blind,      ///< the order says that nobody knows
  synthetic,  ///< it is for a simulated or recorded world
  nonsense,   ///< it is no drive order, or no number
  silent,     ///< the controller does not answer
  rubbish,    ///< it answers otherwise than it should
  count
};
inline constexpr size_t halts = static_cast<size_t>(Halt::count);
/// One word for files, one phrase for people.
std::string_view name(Halt halt);
std::string_view describe(Halt halt);

struct Order {
  Halt halt = Halt::dead;
  double speed = 0, turn_rate = 0;  ///< m/s, rad/s; 0 where it halts
  Reason reason = Reason::none;     ///< of blind
  double age_s = 0;
};

/// May this be driven by now? `timeout_s` alone says what is stale: the client library's own limit follows the frame rate.
Order judge(const Reading& reading, double timeout_s, bool allow_synthetic, int64_t now_ns) noexcept;

/// Topic `drive` of one daemon.
class Orders {
 public:
  Orders(const std::string& instance, double timeout_s, bool allow_synthetic);
  /// What holds now. Never waits.
  Order look();
  /// What more there is to say of an order that halts, for people. May ask the daemon; never waits.
  std::string detail(const Order& order);
  Connection connection();
  /// The daemon has told what it publishes, and `drive` is not among it. Never waits.
  bool not_published();
  uint64_t reconnections() const { return client_.reconnections(); }

 private:
  Client client_;
  Client::Topic topic_;
  double timeout_s_;
  bool allow_synthetic_;
};

}  // namespace vdisp::drive
