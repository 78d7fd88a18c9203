// motors.cpp: one look at everything, one command.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/motors.h"

#include <unistd.h>

#include <algorithm>

#include "daemon/core/clock.h"

namespace vdisp::drive {
namespace {

constexpr int64_t last_word_ns = 100'000'000;
// A controller may hold half a command of whoever was cut short: the first stop only ends that line.
constexpr int stops_to_begin = 2;

}  // namespace

Motors::Motors(const Settings& settings)
    : settings_(settings),
      port_(settings.from.port, settings.from.baud),
      replies_(port_.is_output() ? std::string() : settings.from.reply, std::llround(settings.from.replyTimeout * 1e9)),
      ramp_(settings.from.acceleration, settings.from.deceleration) {}

Motors::~Motors() { finish(); }

Halt Motors::judge(const Order& order, bool ending, int64_t now_ns) {
  const Hearing hearing = replies_.judge(now_ns);
  if (ending) return Halt::ending;
  if (!port_.is_open()) return Halt::no_port;
  if (order.halt != Halt::none) return order.halt;
  if (hearing == Hearing::silent) return Halt::silent;
  return hearing == Hearing::rubbish ? Halt::rubbish : Halt::none;
}

void Motors::look(const Order& order, bool ending, int64_t now_ns) {
  const Halt before = halt_;
  halt_ = judge(order, ending, now_ns);
  if (halt_ != before) ++tally_.stopped[static_cast<size_t>(halt_)];
}

void Motors::read(int64_t now_ns) {
  char bytes[1024];
  const bool was_open = port_.is_open();
  if (const size_t count = port_.receive(bytes, now_ns)) replies_.take({bytes, count}, now_ns);
  if (was_open && !port_.is_open()) ++tally_.port_lost;
}

/// False: it has not been said, and is to be tried again soon.
bool Motors::say(const Phrase& phrase, const Motion& motion, int64_t now_ns) {
  char text[longest_command];
  const size_t bytes = phrase.fill(motion, text);
  if (bytes == 0 && !phrase.empty()) return false;
  const Port::Sent sent = port_.send({text, bytes}, now_ns);
  if (sent == Port::Sent::lost) ++tally_.port_lost;
  return sent == Port::Sent::yes;
}

void Motors::count(int64_t now_ns) {
  ++tally_.commands;
  if (sent_ns_ != 0) {
    tally_.longest_gap_ns = std::max(tally_.longest_gap_ns, now_ns - sent_ns_);
    if (now_ns - sent_ns_ > settings_.period_ns * 3 / 2) ++tally_.late;
  }
  sent_ns_ = now_ns;
}

/// A stand that is ordered is a stop like any other.
void Motors::command(const Order& order, int64_t now_ns) {
  const bool may_move = halt_ == Halt::none && started_;
  Wheels target;
  if (may_move) target = limited(wheels_for(order.speed, order.turn_rate, settings_.from.wheelBase), settings_.from.maxWheelSpeed);
  const bool stop = target == Wheels{};
  const double seconds = static_cast<double>(std::clamp<int64_t>(now_ns - sent_ns_, 0, 2 * settings_.period_ns)) * 1e-9;
  const Ramp before = ramp_;
  if (!stop)
    ramp_.step(target, seconds);
  else if (settings_.stop_is_limited())
    ramp_.step(target, seconds, settings_.from.stopDeceleration);
  else
    ramp_.stand();
  const bool stand = stop && ramp_.now() == Wheels{};
  if (!say(stand ? settings_.stop : settings_.command, settings_.motion(ramp_.now()), now_ns)) {
    ramp_ = before;
    return;
  }
  count(now_ns);
  stops_due_ = stand ? std::max(0, stops_due_ - 1) : 1;
  // From the beat before, so that the rate holds on average; what came out of turn begins a new beat.
  due_ns_ = now_ns < due_ns_ || now_ns - due_ns_ > settings_.period_ns / 2 ? now_ns + settings_.period_ns : due_ns_ + settings_.period_ns;
}

void Motors::serve(const Order& order, bool ending, int64_t now_ns) {
  if (port_.open(now_ns)) {
    ++tally_.port_opened;
    replies_.forget(now_ns);
    ramp_.stand();
    started_ = false;
    stops_due_ = stops_to_begin;
    due_ns_ = now_ns;
    sent_ns_ = 0;
  }
  read(now_ns);
  const Halt before = halt_;
  look(order, ending, now_ns);
  if (port_.is_open()) {
    if (stops_due_ == 0 && !started_) started_ = settings_.start.empty() || say(settings_.start, {}, now_ns);
    const bool orders_stand = halt_ != Halt::none || (order.speed == 0 && order.turn_rate == 0);
    const bool at_once = !started_ || (orders_stand && !(settings_.stop_is_limited() && before == halt_));
    const bool stop_now = at_once && stops_due_ > 0;
    if (stop_now || now_ns >= due_ns_) command(order, now_ns);
    if (!port_.is_open()) look(order, ending, now_ns);
  }
  if (!port_.is_open()) {
    ramp_.stand();
    due_ns_ = now_ns + settings_.period_ns;
  }
}

void Motors::finish() {
  const int64_t end = monotonic_ns() + last_word_ns;
  for (int64_t now = monotonic_ns(); port_.is_open() && now < end; now = monotonic_ns()) {
    if (say(settings_.stop, {}, now)) {
      port_.drain(end - now);
      break;
    }
    usleep(1000);
  }
  port_.close();
}

}  // namespace vdisp::drive
