// flight.cpp: vdisp-probe dump-flight: asks the flight recorder for a folder, and waits until it is written.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "probe/asked_flight.h"
#include "probe/attach.h"
#include "probe/samples.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

constexpr std::chrono::seconds begins_within{5}, longest{120};  // the ring may hold many seconds
constexpr int fewest_looks = 6;                                 // where steps are rare

RecorderStatus look(Client& client, Client::Topic topic) {
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    const Reading reading = client.wait(topic, Client::Time(100));
    const RecorderStatus* status = reading.image ? record_of<RecorderStatus>(*reading.image) : nullptr;
    if (!status) continue;
    RecorderStatus copy = *status;
    client.release(topic);
    return copy;
  }
  throw ProbeError(69, "the daemon does not tell of its flight recorder within 5 s; is it stopped?");
}

}  // namespace

int dump_flight(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  require(topics_of(client), "recorder");
  const Client::Topic topic = client.subscribe("recorder");
  const RecorderStatus before = look(client, topic);
  if (!before.flight)
    throw ProbeError(78, "the daemon keeps no flight recorder; set [recorder] seconds and folder in its vdisp.cfg and start it anew");
  Control control(options.control);
  require_done(control, options, [&] { return control.event(dump_flight_label); });
  AskedFlight flight(before);
  const auto start = std::chrono::steady_clock::now();
  auto state = AskedFlight::State::awaited;
  for (int looks = 0; !stopped() && state <= AskedFlight::State::writing; ++looks) {
    const RecorderStatus now = look(client, topic);
    state = flight.see(now);
    const auto waited = std::chrono::steady_clock::now() - start;
    const bool awaited = state == AskedFlight::State::awaited && !now.writing;
    if (awaited && waited > begins_within && looks >= fewest_looks)
      throw ProbeError(69, "the daemon took the order, and its flight recorder did not begin within 5 s");
    if (state <= AskedFlight::State::writing && waited > longest) throw ProbeError(69, "the flight recorder has not finished within 120 s");
  }
  if (stopped()) return 0;
  const std::string text = flight.text();
  if (state == AskedFlight::State::overtaken)
    throw ProbeError(69, "the flight recorder was done, and with a later folder too, before this could look: " + text);
  if (state == AskedFlight::State::failed) throw ProbeError(74, "the flight recorder could not write: " + text);
  print(options.json ? nlohmann::ordered_json{{"folder", text}}.dump() + "\n" : text + "\n");
  return 0;
}

}  // namespace vdisp
