// report.cpp: edges become lines, at most one a second; what flickers is told once, with how often.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/report.h"

#include <poll.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/log/log.h"

namespace vdisp::drive {
namespace {

constexpr int64_t second = 1'000'000'000;

}  // namespace

Report::State Report::state(const Motors& motors, const Order& order, Orders& orders, int64_t now_ns) {
  State state;
  state.halt = motors.halt();
  if (state.halt == Halt::no_port) state.fault = motors.port().fault();
  if (state.halt == Halt::blind) state.reason = order.reason;
  if (state.halt == Halt::dead || (state.halt == Halt::stale && order.age_s == 0)) {
    if (now_.halt == state.halt && now_ns - asked_ns_ < second) return now_;
    asked_ns_ = now_ns;
    if (state.halt == Halt::dead)
      state.connection = orders.connection();
    else
      state.not_published = orders.not_published();
  }
  return state;
}

std::string Report::why(const Motors& motors, const Order& order, Orders& orders) {
  const Halt halt = motors.halt();
  const std::string detail = halt == Halt::no_port   ? motors.port().fault()
                             : halt == Halt::rubbish ? "'" + motors.replies().wrong() + "'"
                                                     : orders.detail(order);
  return std::string(describe(halt)) + (detail.empty() ? "" : ": " + detail);
}

void Report::tell(int64_t now_ns) {
  const std::string flicker = untold_ > 1 ? fmt::format(" ({} changes since the last message)", untold_) : "";
  if (now_.halt != Halt::none && now_.halt != Halt::ending)
    log::warn("motors stopped: {}{}", why_, flicker);
  else if (now_.halt == Halt::ending)
    log::info("motors stopped: {}{}", why_, flicker);
  else if (why_.empty())
    log::info("motors driven");
  else
    log::info("motors driven after {:.1f} s; stopped was: {}{}", static_cast<double>(driven_ns_ - since_ns_) * 1e-9, why_, flicker);
  told_ = now_;
  told_ns_ = now_ns;
  untold_ = 0;
}

void Report::see(const Motors& motors, const Order& order, Orders& orders, int64_t now_ns) {
  if (motors.tally().port_opened != opened_) {
    opened_ = motors.tally().port_opened;
    if (!motors.port().is_output()) log::info("port {} is open{}", motors.port().name(), opened_ > 1 ? " again" : "");
  }
  State state = this->state(motors, order, orders, now_ns);
  if (!(state == now_)) {
    if (now_.halt == Halt::none || now_.halt == Halt::count) since_ns_ = now_ns;
    now_ = std::move(state);
    if (now_.halt == Halt::none)
      driven_ns_ = now_ns;
    else
      why_ = why(motors, order, orders);
    ++untold_;
  }
  // Also where it is again what was told last: something was in between.
  if (untold_ > 0 && (told_.halt == Halt::count || now_.halt == Halt::ending || now_ns - told_ns_ >= second)) tell(now_ns);
  if (json_ && (written_ != motors.halt() || now_ns - written_ns_ >= second)) write_json(motors, order, orders.reconnections(), now_ns);
}

void Report::write_json(const Motors& motors, const Order& order, uint64_t reconnections, int64_t now_ns) {
  written_ns_ = now_ns;
  written_ = motors.halt();
  const Tally& tally = motors.tally();
  nlohmann::ordered_json line;
  line["state"] = motors.halt() == Halt::none ? "driven" : "stopped";
  line["why"] = motors.halt() == Halt::none ? nlohmann::ordered_json() : nlohmann::ordered_json(std::string(name(motors.halt())));
  line["order"] = {{"speed", order.speed}, {"turn_rate", order.turn_rate}, {"age_s", std::round(order.age_s * 1e4) / 1e4}};
  line["wheels"] = {{"left", motors.wheels().left}, {"right", motors.wheels().right}};
  line["port"] = {{"open", motors.port().is_open()}, {"opened", tally.port_opened}, {"lost", tally.port_lost}};
  line["commands"] = {{"sent", tally.commands},
                      {"late", tally.late},
                      {"longest_gap_s", std::round(static_cast<double>(tally.longest_gap_ns) * 1e-5) / 1e4}};
  line["replies"] = {{"right", motors.replies().right_lines()}, {"wrong", motors.replies().wrong_lines()}};
  for (size_t i = 1; i < halts; ++i) line["stops"][std::string(name(static_cast<Halt>(i)))] = tally.stopped[i];
  line["reconnections"] = reconnections;
  line["skipped"] = skipped_;
  const std::string text = line.dump() + "\n";
  // A reader that does not read must not keep the motors waiting.
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  if (poll(&output, 1, 0) == 0 || write(STDOUT_FILENO, text.data(), text.size()) != static_cast<ssize_t>(text.size())) ++skipped_;
}

void Report::finish(const Motors& motors, int64_t now_ns) {
  if (json_) write_json(motors, {}, 0, now_ns);
  const Tally& tally = motors.tally();
  uint64_t stops = 0;
  for (size_t i = 1; i < halts; ++i) stops += tally.stopped[i];
  log::info("{} commands, {} of them late, longest pause {:.0f} ms; stopped {} times; port lost {} times; {} replies, {} wrong ones",
            tally.commands, tally.late, static_cast<double>(tally.longest_gap_ns) * 1e-6, stops, tally.port_lost,
            motors.replies().right_lines() + motors.replies().wrong_lines(), motors.replies().wrong_lines());
}

}  // namespace vdisp::drive
