// attach.cpp: reaching the daemon, in words and exit codes.
// SPDX-License-Identifier: Apache-2.0
#include "probe/attach.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "ipc/endpoint.h"

namespace vdisp {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

// A daemon that is well finds a new reader in its next round, after 0.1 s on an idle machine; one that is stopped is known by 1 s of
// silence, one of another name by 2 s.
constexpr double answer_s = 2.5, longest_round_s = 0.5;

void request_stop(int) { stop_requested = 1; }

}  // namespace

void attach(Client& client, const Options& options) {
  using Clock = std::chrono::steady_clock;
  Connection connection = client.connection();
  double waited_s = 0;
  while (connection == Connection::no_daemon && !stopped()) {
    const bool served = probe_socket(roudi_socket) == Probe::alive;
    if (waited_s >= (served ? std::max(options.wait_s, answer_s) : options.wait_s)) break;
    const Clock::time_point begin = Clock::now();
    connection = client.wait_for_daemon(Client::Time(200)) ? Connection::connected : client.connection();
    // One that was itself stopped (SIGSTOP) has not waited for the daemon.
    waited_s += std::min(std::chrono::duration<double>(Clock::now() - begin).count(), longest_round_s);
  }
  switch (connection) {
    case Connection::connected: return;
    case Connection::no_daemon: throw ProbeError(69, client.message());
    case Connection::no_permission: throw ProbeError(77, client.message());
    case Connection::no_memory: throw ProbeError(71, client.message());
    case Connection::wrong_name: throw ProbeError(64, client.message());
  }
}

std::vector<CatalogueEntry> topics_of(Client& client) {
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    std::vector<CatalogueEntry> topics = client.topics(Client::Time(100));
    if (!topics.empty()) return topics;
  }
  throw ProbeError(69, "the daemon sent no catalogue of its stages within 5 s; is it still starting, or stopped?");
}

void require(const std::vector<CatalogueEntry>& topics, const std::string& topic) {
  std::string all;
  for (const CatalogueEntry& entry : topics) {
    if (name_of(entry) == topic) return;
    if (name_of(entry) != "catalogue" && name_of(entry) != "heartbeat") all += " " + std::string(name_of(entry));
  }
  throw ProbeError(64, "the daemon has no stage '" + topic + "'; it has" + all);
}

std::string_view name_of(const CatalogueEntry& entry) { return {entry.name, strnlen(entry.name, sizeof entry.name)}; }

void stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = request_stop;  // no SA_RESTART: waits in system calls end
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

bool stopped() { return stop_requested != 0; }

std::string_view name(Trust trust) {
  switch (trust) {
    case Trust::fresh: return "fresh";
    case Trust::blind: return "blind";
    case Trust::stale: return "stale";
    case Trust::dead: return "dead";
  }
  return "unknown";
}

std::string state_words(const Reading& reading) {
  char age[32];
  std::snprintf(age, sizeof age, "%.1f s old", reading.age_s);
  switch (reading.trust) {
    case Trust::fresh: return "FRESH";
    case Trust::blind: return "BLIND: " + std::string(describe(reading.reason));
    case Trust::stale: return reading.image ? "STALE: " + std::string(age) : "STALE: nothing has arrived yet";
    case Trust::dead: return "DEAD: no daemon, waiting";
  }
  return "unknown";
}

}  // namespace vdisp
