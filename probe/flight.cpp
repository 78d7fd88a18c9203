// flight.cpp: vdisp-probe dump-flight: asks the flight recorder for a folder, and waits until it is written.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "probe/attach.h"
#include "probe/samples.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

constexpr int longest_s = 120;  // of writing: the ring may hold many seconds

RecorderStatus look(Client& client, Client::Topic topic) {
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    const Reading reading = client.wait(topic, Client::Time(100));
    const RecorderStatus* status = reading.image ? record_of<RecorderStatus>(*reading.image) : nullptr;
    if (!status) continue;
    RecorderStatus copy = *status;
    copy.text[sizeof copy.text - 1] = 0;
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
  // One that was being written when this was asked is not the one that was asked for.
  const uint64_t wanted = before.asked + 1, ready = before.written + before.failed + 1 + before.writing;
  RecorderStatus now = before;
  const auto start = std::chrono::steady_clock::now();
  while (!stopped() && (now.asked < wanted || now.written + now.failed < ready)) {
    if (std::chrono::steady_clock::now() - start > std::chrono::seconds(now.asked < wanted && !now.writing ? 5 : longest_s))
      throw ProbeError(69, now.asked < wanted ? "the daemon took the order, and its flight recorder did not begin within 5 s"
                                              : "the flight recorder has not finished within 120 s");
    now = look(client, topic);
  }
  if (stopped()) return 0;
  if (now.failed > before.failed) throw ProbeError(74, std::string("the flight recorder could not write: ") + now.text);
  print(options.json ? nlohmann::ordered_json{{"folder", now.text}}.dump() + "\n" : std::string(now.text) + "\n");
  return 0;
}

}  // namespace vdisp
