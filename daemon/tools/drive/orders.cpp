// orders.cpp: every reason not to drive is found here, before the one to drive.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/orders.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "daemon/core/clock.h"

namespace vdisp::drive {
namespace {

constexpr double most_early_s = 0.001;  // the clocks are one clock: an order from the future is damaged

}  // namespace

std::string_view name(Halt halt) {
  constexpr std::string_view names[] = {"none",  "ending",    "no_port",  "dead",   "stale",  "over",
                                        "blind", "synthetic", "nonsense", "silent", "rubbish"};
  static_assert(std::size(names) == halts);
  return names[static_cast<size_t>(halt)];
}

std::string_view describe(Halt halt) {
  constexpr std::string_view phrases[] = {"they do what is ordered",
                                          "told to end",
                                          "no serial port",
                                          "no daemon",
                                          "no order",
                                          "the operator's order is over: none for 0.3 s, or none in the last frame",
                                          "the order is blind",
                                          "the order is for a simulated or recorded world; --allow-synthetic drives by it",
                                          "the order is none: not a number, or not of this version",
                                          "the controller does not answer",
                                          "the controller answers what it should not"};
  static_assert(std::size(phrases) == halts);
  return phrases[static_cast<size_t>(halt)];
}

Order judge(const Reading& reading, double timeout_s, bool allow_synthetic, int64_t now_ns) noexcept {
  Order order;
  order.age_s = reading.age_s;
  const auto halt = [&](Halt why) {
    order.halt = why;
    return order;
  };
  if (reading.trust == Trust::dead) return halt(Halt::dead);
  if (!reading.image) return halt(Halt::stale);
  if (reading.age_s > timeout_s) return halt(Halt::stale);
  order.reason = reading.image->reason;
  if (!reading.image->valid()) return halt(Halt::blind);
  const DriveCommand* command = record_of<DriveCommand>(*reading.image);
  if (!command || !std::isfinite(command->speed) || !std::isfinite(command->turn_rate)) return halt(Halt::nonsense);
  if (reading.age_s < -most_early_s) return halt(Halt::nonsense);
  if (command->valid_until_ns != 0 && now_ns >= command->valid_until_ns) return halt(Halt::over);
  if ((reading.image->flags & flag_synthetic) && !allow_synthetic) return halt(Halt::synthetic);
  order.speed = command->speed;
  order.turn_rate = command->turn_rate;
  return halt(Halt::none);
}

Orders::Orders(const std::string& instance, double timeout_s, bool allow_synthetic)
    : client_(instance), topic_(client_.subscribe("drive")), timeout_s_(timeout_s), allow_synthetic_(allow_synthetic) {}

Order Orders::look() { return judge(client_.latest(topic_), timeout_s_, allow_synthetic_, monotonic_ns()); }

Connection Orders::connection() { return client_.connection(Client::Time(0)); }

bool Orders::not_published() {
  const auto topics = client_.topics(Client::Time(0));
  return !topics.empty() &&
         std::none_of(topics.begin(), topics.end(), [](const CatalogueEntry& entry) { return std::string_view(entry.name) == "drive"; });
}

std::string Orders::detail(const Order& order) {
  switch (order.halt) {
    case Halt::dead:
      return connection() == Connection::connected ? "vdispd gives no sign of life: it hangs or is stopped" : client_.message();
    case Halt::blind: return std::string(vdisp::describe(order.reason));
    case Halt::stale: {
      if (order.age_s > 0) {
        char text[64];
        std::snprintf(text, sizeof text, "none for %.2f s", order.age_s);
        return text;
      }
      return not_published() ? "vdispd publishes no drive: is [main] detectors = none?" : "none has come yet";
    }
    default: return {};
  }
}

}  // namespace vdisp::drive
