// send.cpp: vdisp-probe send: samples from a file or standard input, in their own time or at a rate.
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "probe/attach.h"
#include "probe/samples.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

using Clock = std::chrono::steady_clock;

/// When lines are due, counted from the first one, which may have waited for a daemon.
class Pace {
 public:
  explicit Pace(double rate) : rate_(rate) {}
  void begin(const Samples::Line& first) {
    start_ = Clock::now();
    first_ns_ = first.timestamp_ns.value_or(0);
  }
  /// `number`: of the line, from 0.
  void wait(const Samples::Line& line, uint64_t number) const {
    if (number == 0) return;
    std::chrono::nanoseconds due{0};
    if (rate_ > 0) {
      due = std::chrono::nanoseconds(static_cast<int64_t>(static_cast<double>(number) * 1e9 / rate_));
    } else if (line.timestamp_ns) {
      due = std::chrono::nanoseconds(*line.timestamp_ns - first_ns_);
    }
    while (Clock::now() - start_ < due && !stopped())
      std::this_thread::sleep_for(std::min<Clock::duration>(due - (Clock::now() - start_), std::chrono::milliseconds(50)));
  }

 private:
  double rate_;
  Clock::time_point start_;
  int64_t first_ns_ = 0;
};

}  // namespace

/// Every line is stamped with the time it is sent at: the clock of a recording is not this machine's.
int send(const Options& options) {
  const bool one_event = options.key == "event" && !options.value.empty();
  if (!options.value.empty() && options.key != "event")
    throw ProbeError(64, "'" + options.value + "': only an event has a label; see vdisp-probe send --help");
  std::ifstream file;
  if (!options.input.empty()) {
    file.open(options.input);
    if (!file) throw ProbeError(66, options.input.string() + ": cannot be read; needed is a CSV");
  }
  std::istream& lines = options.input.empty() ? std::cin : file;
  stop_on_signals();
  Control control(options.control);
  Samples samples(options.key);
  Pace pace(options.rate);
  uint64_t sent = 0;
  if (one_event) require_done(control, options, [&] { return control.event(options.value); });
  for (std::string text; !one_event && !stopped() && std::getline(lines, text);) {
    const auto line = samples.read(text);
    if (!line) continue;
    pace.wait(*line, sent);
    if (stopped()) break;
    require_done(control, options, [&] { return samples.send(control, *line, 0); });
    if (sent == 0) pace.begin(*line);
    ++sent;
  }
  if (one_event) sent = 1;
  print(options.json ? nlohmann::ordered_json{{"sent", sent}}.dump() + "\n" : std::to_string(sent) + " sent\n");
  return 0;
}

}  // namespace vdisp
