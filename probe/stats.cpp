// stats.cpp: vdisp-probe stats: what each stage costs, once a second.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "probe/attach.h"
#include "probe/health.h"
#include "probe/kept.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

double ms(int64_t ns) { return static_cast<double>(ns) / 1e6; }

/// One stage: its topics share its times.
struct Line {
  std::string names;
  CatalogueEntry entry;
  double rate = 0;  ///< runs per second since the catalogue before; 0: not known
};

std::vector<Line> lines_of(const Catalogue& now, const Catalogue* before, double seconds) {
  std::map<uint32_t, Line> stages;
  for (uint32_t i = 0; i < std::min(now.count, Catalogue::capacity); ++i) {
    const CatalogueEntry& entry = now.entries[i];
    auto [place, is_new] = stages.try_emplace(entry.stage, Line{std::string(name_of(entry)), entry});
    Line& line = place->second;
    if (!is_new) {
      line.names += " " + std::string(name_of(entry));
      line.entry.drops += entry.drops;
      line.entry.watched |= entry.watched;
    }
    if (before && seconds > 0 && i < before->count && name_of(before->entries[i]) == name_of(entry))
      line.rate = static_cast<double>(entry.runs - before->entries[i].runs) / seconds;
  }
  std::vector<Line> lines;
  for (auto& [stage, line] : stages) lines.push_back(std::move(line));
  return lines;
}

std::string table(const Catalogue& catalogue, const std::vector<Line>& lines, const std::string& state) {
  char text[256];
  const double hz = catalogue.period_ns > 0 ? 1e9 / static_cast<double>(catalogue.period_ns) : 0;
  std::snprintf(text, sizeof text, "%s   %llu steps, %llu blind, %.1f Hz, %.2f ms a step\n\n", state.c_str(),
                static_cast<unsigned long long>(catalogue.steps), static_cast<unsigned long long>(catalogue.blind_steps), hz,
                ms(catalogue.step_mean_ns));
  std::string out = text;
  size_t width = 5;
  for (const Line& line : lines) width = std::max(width, line.names.size());
  const int names = static_cast<int>(std::min<size_t>(width, 30));
  std::snprintf(text, sizeof text, "%-*s %9s %8s %7s %9s %9s %9s %7s\n", names, "stage", "runs", "invalid", "drops", "last ms", "mean ms",
                "max ms", "Hz");
  out += text;
  for (const Line& line : lines) {
    const CatalogueEntry& e = line.entry;
    char rate[16] = "-";
    if (line.rate > 0) std::snprintf(rate, sizeof rate, "%.1f", line.rate);
    std::snprintf(text, sizeof text, "%-*.*s %9llu %8llu %7llu %9.2f %9.2f %9.2f %7s\n", names, names, line.names.c_str(),
                  static_cast<unsigned long long>(e.runs), static_cast<unsigned long long>(e.invalid),
                  static_cast<unsigned long long>(e.drops), ms(e.last_ns), ms(e.mean_ns), ms(e.max_ns), rate);
    out += text;
  }
  return out;
}

/// The daemon's losses; null: not told yet.
struct Told {
  const Health* health = nullptr;
  const RecorderStatus* recorder = nullptr;
  bool all() const { return health && recorder; }
};

std::string json(const Catalogue& catalogue, const std::vector<Line>& lines, const Told& told, std::string_view state) {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  for (const Line& line : lines) {
    const CatalogueEntry& e = line.entry;
    stages.push_back({{"stage", line.names},
                      {"watched", e.watched != 0},
                      {"runs", e.runs},
                      {"invalid", e.invalid},
                      {"drops", e.drops},
                      {"last_ns", e.last_ns},
                      {"mean_ns", e.mean_ns},
                      {"max_ns", e.max_ns},
                      {"rate_hz", line.rate > 0 ? nlohmann::ordered_json(line.rate) : nlohmann::ordered_json(nullptr)}});
  }
  const nlohmann::ordered_json all{{"state", state},
                                   {"steps", catalogue.steps},
                                   {"blind_steps", catalogue.blind_steps},
                                   {"period_ns", catalogue.period_ns},
                                   {"step_mean_ns", catalogue.step_mean_ns},
                                   {"health", told.health ? health_json(*told.health) : nlohmann::ordered_json(nullptr)},
                                   {"recorder", told.recorder ? recorder_json(*told.recorder) : nlohmann::ordered_json(nullptr)},
                                   {"stages", stages}};
  return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// The newest catalogue and the one before it, for rates.
class History {
 public:
  /// True where the reading is a catalogue not seen before.
  bool take(const Reading& reading) {
    if (!reading.image || !record_of<Catalogue>(*reading.image)) return false;
    const Image* last = now();
    if (last && last->ready_ns == reading.image->ready_ns && last->epoch == reading.image->epoch) return false;
    if (last && last->epoch != reading.image->epoch) kept_[1 - newest_].drop();
    newest_ = 1 - newest_;
    kept_[newest_].keep(*reading.image);
    return true;
  }
  const Image* now() const { return kept_[newest_].get(); }
  std::vector<Line> lines() const {
    const Image* before = kept_[1 - newest_].get();
    if (before && before->epoch != now()->epoch) before = nullptr;
    const double seconds = before ? static_cast<double>(now()->ready_ns - before->ready_ns) / 1e9 : 0;
    return lines_of(*record_of<Catalogue>(*now()), before ? record_of<Catalogue>(*before) : nullptr, seconds);
  }

 private:
  KeptImage kept_[2];
  int newest_ = 0;
};

/// The newest record of a topic, which is told with the catalogue.
template <class Record>
struct Newest {
  Client::Topic topic;
  KeptImage kept;
  const Record* look(Client& client, uint64_t epoch) {
    const Reading reading = client.latest(topic);
    if (reading.image && record_of<Record>(*reading.image)) kept.keep(*reading.image);
    return kept.get() && kept.get()->epoch == epoch ? record_of<Record>(*kept.get()) : nullptr;
  }
};

struct Losses {
  explicit Losses(Client& client) : health{client.subscribe("health"), {}}, recorder{client.subscribe("recorder"), {}} {}
  Newest<Health> health;
  Newest<RecorderStatus> recorder;
  Told look(Client& client, uint64_t epoch) { return {health.look(client, epoch), recorder.look(client, epoch)}; }
};

std::string report(const History& history, const Told& told, const Reading& reading, bool as_json) {
  const Catalogue& catalogue = *record_of<Catalogue>(*history.now());
  const std::string state(reading.trust == Trust::dead ? "no daemon, waiting" : reading.trust == Trust::stale ? "stale" : "running");
  if (as_json) return json(catalogue, history.lines(), told, state);
  return table(catalogue, history.lines(), state) + (told.health ? "\n" + health_words(*told.health) : "") +
         (told.recorder ? recorder_words(*told.recorder) : "");
}

int print_once(Client& client, Client::Topic topic, Losses& losses, bool as_json) {
  History history;
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    const Reading reading = client.wait(topic, Client::Time(100));
    if (!history.take(reading)) continue;
    Told told = losses.look(client, reading.image->epoch);
    for (int more = 0; !told.all() && more < 12 && !stopped(); ++more) {
      client.wait(told.health ? losses.recorder.topic : losses.health.topic, Client::Time(100));
      told = losses.look(client, history.now()->epoch);
    }
    print(report(history, told, reading, as_json));
    return 0;
  }
  if (stopped()) return 0;
  throw ProbeError(69, "the daemon sent no catalogue of its stages within 5 s; is it still starting, or stopped?");
}

}  // namespace

int stats(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  const Client::Topic topic = client.subscribe("catalogue");
  Losses losses(client);
  if (options.once) return print_once(client, topic, losses, options.json);
  History history;
  LiveScreen screen;
  Trust last_trust = Trust::fresh;
  while (!stopped()) {
    const char key = screen.key(100);
    if (key == 'q' || key == 27) break;
    const Reading reading = client.wait(topic, Client::Time(100));
    const bool news = history.take(reading) || reading.trust != last_trust;
    last_trust = reading.trust;
    if (!news || !history.now()) continue;
    const Told told = losses.look(client, history.now()->epoch);
    screen.show(report(history, told, reading, options.json) + (screen.live() && !options.json ? "\nq ends\n" : ""));
  }
  return 0;
}

}  // namespace vdisp
