// settings.cpp: what no range of the table can say of [drive].
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/settings.h"

#include <algorithm>
#include <cstdio>

#include "daemon/tools/drive/replies.h"

namespace vdisp::drive {
namespace {

constexpr double bits_per_byte = 10;  // with start and stop bit

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

class Check {
 public:
  explicit Check(std::vector<std::string>& complaints) : complaints_(complaints) {}

  void refuse(const std::string& what) { complaints_.push_back("[drive] " + what); }

  Phrase phrase(const char* key, const std::string& text) {
    try {
      return Phrase(text);
    } catch (const PhraseError& error) {
      refuse(std::string(key) + " = '" + text + "': " + error.what());
      return {};
    }
  }

  bool clean() const { return complaints_.empty(); }

 private:
  std::vector<std::string>& complaints_;
};

/// Bytes of the longest that it says: wheels at their most, in opposite directions and in one. Complains of what can never be said.
size_t longest(const char* key, const Phrase& phrase, const Settings& settings, Check& check) {
  const double most = settings.from.maxWheelSpeed;
  size_t bytes = 0;
  for (const Wheels& wheels : {Wheels{}, Wheels{-most, -most}, Wheels{-most, most}, Wheels{most, -most}}) {
    char text[longest_command];
    const size_t filled = phrase.fill(settings.motion(wheels), text);
    if (filled == 0 && !phrase.empty()) {
      check.refuse(std::string(key) + ": longer than " + std::to_string(longest_command) + " bytes, must be shorter");
      return 0;
    }
    bytes = std::max(bytes, filled);
  }
  return bytes;
}

void check_times(const Settings& settings, bool serial, Check& check) {
  const drive_section& s = settings.from;
  size_t bytes = longest("command", settings.command, settings, check);
  if (!s.stop.empty()) bytes = std::max(bytes, longest("stop", settings.stop, settings, check));
  longest("start", settings.start, settings, check);
  const double takes_ms = static_cast<double>(bytes) * bits_per_byte * 1000 / s.baud;
  if (serial && takes_ms > 1000 / s.rate)
    check.refuse("a command of " + std::to_string(bytes) + " bytes takes " + number(takes_ms) + " ms with baud = " +
                 std::to_string(s.baud) + ", must fit into " + number(1000 / s.rate) + " ms (rate = " + number(s.rate) + ")");
  if (!s.reply.empty() && s.replyTimeout * s.rate < 2)
    check.refuse("replyTimeout = " + number(s.replyTimeout) + " s, must be at least two periods of rate = " + number(s.rate) + ": " +
                 number(2 / s.rate) + " s");
}

}  // namespace

Motion Settings::motion(const Wheels& wheels) const {
  const double left = from.reverse == "left" || from.reverse == "both" ? -from.wheelScale : from.wheelScale;
  const double right = from.reverse == "right" || from.reverse == "both" ? -from.wheelScale : from.wheelScale;
  return {wheels.left * left, wheels.right * right, speed_of(wheels), turn_rate_of(wheels, from.wheelBase)};
}

Settings read_settings(const Config& config, const std::string& port, std::vector<std::string>& complaints) {
  Check check(complaints);
  Settings settings;
  settings.from = config.drive;
  drive_section& s = settings.from;
  if (!port.empty()) s.port = port;
  settings.period_ns = std::llround(1e9 / s.rate);
  if (s.port.empty())
    check.refuse("port is not told, must be the motor controller's, as /dev/serial/by-id/NAME; - writes the commands to standard output");
  settings.command = check.phrase("command", s.command);
  settings.stop = check.phrase("stop", s.stop);
  settings.start = check.phrase("start", s.start);
  if (check.clean() && !settings.command.tells_motion())
    check.refuse("command = '" + s.command + "': must have {left} and {right}, or {speed} and {turn}");
  if (settings.start.has_fields())
    check.refuse("start = '" + s.start + "': has a field, must be text alone: it is said once, before any order");
  try {
    Replies(s.reply, 0);
  } catch (const std::invalid_argument& error) {
    check.refuse("reply = '" + s.reply + "': " + error.what());
  }
  if (settings.stop.empty()) settings.stop = settings.command;  // at 0
  if (check.clean()) check_times(settings, s.port != "-", check);
  return settings;
}

}  // namespace vdisp::drive
