// latency.cpp: vdisp-probe latency: from the exposure to the map, by the daemon's own count or in a reader's hands.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "probe/attach.h"
#include "probe/format.h"
#include "probe/health.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

using Clock = std::chrono::steady_clock;

struct Measured {
  LatencyHistogram latency{};
  std::optional<double> seconds;  ///< nothing: since the start of the daemon
  uint64_t blind = 0, missed = 0;
  int64_t deadline_ns = 0;
  bool synthetic = false;
};

int64_t now_ns() { return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count(); }
double ms(int64_t ns) { return static_cast<double>(ns) / 1e6; }

/// A look at `health`, newer than `after_ns`.
std::optional<Health> look(Client& client, Client::Topic topic, int64_t after_ns) {
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    const Reading reading = client.wait(topic, Client::Time(100));
    const Health* health = reading.image ? record_of<Health>(*reading.image) : nullptr;
    if (health && reading.image->ready_ns > after_ns) return *health;
  }
  if (stopped()) return std::nullopt;
  throw ProbeError(69, "the daemon told nothing of its health within 5 s; is it still starting, stopped, or of another version?");
}

std::optional<Measured> of_daemon(Client& client, double seconds) {
  const Client::Topic topic = client.subscribe("health");
  const std::optional<Health> first = look(client, topic, 0);
  if (!first) return std::nullopt;
  if (seconds <= 0) return Measured{first->latency, std::nullopt, first->blind_frames, first->deadline_misses, first->deadline_ns};
  const auto start = Clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  while (passed() < seconds && !stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const int64_t then = now_ns();
  const std::optional<Health> last = look(client, topic, then);
  if (!last) return std::nullopt;
  if (last->since_ns != first->since_ns) throw ProbeError(69, "the daemon was started anew meanwhile; measure again");
  return Measured{last->latency.since(first->latency), passed(), last->blind_frames - first->blind_frames,
                  last->deadline_misses - first->deadline_misses, last->deadline_ns};
}

/// A planner that waits for maps, and asks when the pair of each was there: what it gets and when.
std::optional<Measured> in_hands(Client& client, double seconds) {
  // in/event is made right behind the pair, and published at once; the views are when their last reader in the tree has run.
  const Client::Topic topics[] = {client.subscribe("map"), client.subscribe("in/event")};
  Measured measured;
  std::optional<uint64_t> last;
  uint64_t epoch = 0;
  const auto start = Clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  while (passed() < seconds && !stopped()) {
    Reading set[2];
    if (!client.wait_set(topics, set, Client::Time(100))) continue;
    const int64_t now = now_ns();
    const Image& map = *set[0].image;
    const bool first = !last || map.epoch != epoch;
    if (!first) measured.missed += map.sequence - *last - 1;
    last = map.sequence;
    epoch = map.epoch;
    measured.synthetic = map.flags & flag_synthetic;
    if (!map.valid())
      ++measured.blind;
    else if (!first)  // the first one lay there
      measured.latency.add(now - (measured.synthetic ? set[1].image->ready_ns : map.timestamp_ns));
  }
  if (!last && !stopped()) throw ProbeError(69, "no map came within " + format("%.1f s", seconds) + "; see vdisp-probe stats");
  measured.seconds = passed();
  return measured;
}

/// A line for each quarter of a doubling between the shortest and the longest.
std::string bars(const LatencyHistogram& latency) {
  constexpr uint32_t together = LatencyHistogram::parts / 4;
  constexpr int width = 50;
  uint64_t most = 0;
  uint32_t first = LatencyHistogram::buckets, last = 0;
  const auto count_of = [&](uint32_t begin) {
    uint64_t count = 0;
    for (uint32_t i = begin; i < begin + together; ++i) count += latency.counts[i];
    return count;
  };
  for (uint32_t i = 0; i < LatencyHistogram::buckets; i += together) {
    const uint64_t count = count_of(i);
    most = std::max(most, count);
    if (count > 0) first = std::min(first, i), last = i;
  }
  std::string text;
  for (uint32_t i = first; i <= last && i < LatencyHistogram::buckets; i += together) {
    const uint64_t count = count_of(i);
    const auto letters = static_cast<size_t>((count * width + most - 1) / most);
    text += format("%8.2f - %8.2f ms %9llu  ", ms(LatencyHistogram::begin_ns(i)), ms(LatencyHistogram::begin_ns(i + together)),
                   static_cast<unsigned long long>(count)) +
            std::string(letters, '#') + "\n";
  }
  return text;
}

std::string words(const Measured& measured, bool reader) {
  std::string text = "from the exposure to the map";
  text += reader ? " in a reader's hands" : "";
  text += measured.seconds ? format(", %.1f s", *measured.seconds) : ", since the start of the daemon";
  text += format(": %llu maps\n", static_cast<unsigned long long>(measured.latency.count)) + latency_words(measured.latency);
  if (measured.latency.count > 0)
    text += format("  mean %.2f ms", ms(measured.latency.sum_ns) / static_cast<double>(measured.latency.count));
  text += "\n";
  if (reader) {
    text += format("missed %llu, blind %llu\n", static_cast<unsigned long long>(measured.missed),
                   static_cast<unsigned long long>(measured.blind));
  } else if (measured.deadline_ns > 0) {
    text += format("deadline %.1f ms, missed %llu times\n", ms(measured.deadline_ns), static_cast<unsigned long long>(measured.missed));
  }
  return text + bars(measured.latency);
}

std::string json(const Measured& measured, bool reader) {
  nlohmann::ordered_json all{{"of", reader ? "reader" : "daemon"},
                             {"seconds", measured.seconds ? nlohmann::ordered_json(*measured.seconds) : nlohmann::ordered_json(nullptr)}};
  all.update(latency_json(measured.latency));
  all["blind"] = measured.blind;
  all["missed"] = measured.missed;
  if (!reader)
    all["deadline_ms"] = measured.deadline_ns > 0 ? nlohmann::ordered_json(ms(measured.deadline_ns)) : nlohmann::ordered_json(nullptr);
  all["histogram"] = nlohmann::ordered_json::array();
  for (uint32_t i = 0; i < LatencyHistogram::buckets; ++i)
    if (measured.latency.counts[i] > 0)
      all["histogram"].push_back({{"from_ms", ms(LatencyHistogram::begin_ns(i))},
                                  {"to_ms", ms(LatencyHistogram::begin_ns(i + 1))},
                                  {"count", measured.latency.counts[i]}});
  return all.dump() + "\n";
}

}  // namespace

int latency(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  const double seconds = options.reader && options.seconds <= 0 ? 10 : options.seconds;
  const std::optional<Measured> measured = options.reader ? in_hands(client, seconds) : of_daemon(client, seconds);
  if (measured) print(options.json ? json(*measured, options.reader) : words(*measured, options.reader));
  return 0;
}

}  // namespace vdisp
