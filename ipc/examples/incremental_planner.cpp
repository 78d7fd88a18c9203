// incremental_planner.cpp: a dynamic planner in the manner of E*: reads only what changed in the map, and plans only where that matters.
// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "planned.h"
#include "vdisp/client.h"

using namespace planner;
using namespace vdisp;

static const char usage[] =
    "usage: vdisp-incremental-planner X Y [--unknown SPEED] [--radius M] [--buffer M] [--fused] [--frames N] [--json] [--compare]\n"
    "  X Y              the goal, m ahead of the rover and to its left (negative: right)\n"
    "  --unknown SPEED  how fast through cells nobody has seen, 0 (never) to 1 (as free ground); 0.5\n"
    "  --radius M       of the rover: no nearer than this to obstacles, 0 to 5 m; 0\n"
    "  --buffer M       and slower this much farther from them, 0 to 5 m; 0.3\n"
    "  --fused          plan in the map that remembers (`fused`), not in the frame's\n"
    "  --frames N       N frames, blind ones counted, then end; 69 where no daemon comes within 5 s. Without it: for ever\n"
    "  --json           one line of JSON for each frame, instead of a picture twice a second\n"
    "  --compare        also plan anew in each frame, and compare\n";

struct Options {
  Point goal;
  Policy policy;
  long frames = -1;
  bool json = false, compare = false, fused = false;
};

template <class T>
static bool number(const char* text, T low, T high, T& value) {
  const char* end = text + std::strlen(text);
  const auto [at, error] = std::from_chars(text, end, value);
  return error == std::errc() && at == end && value >= low && value <= high;  // false for NaN
}

static bool parse(int argc, char** argv, Options& options) {
  if (argc < 3 || !number(argv[1], -1e3, 1e3, options.goal.x) || !number(argv[2], -1e3, 1e3, options.goal.y)) return false;
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--json" || word == "--compare" || word == "--fused")
      (word == "--json" ? options.json : word == "--fused" ? options.fused : options.compare) = true;
    else if (word == "--unknown" && number(value, 0.0, 1.0, options.policy.unknown_speed))
      ++i;
    else if (word == "--radius" && number(value, 0.0, 5.0, options.policy.radius_m))
      ++i;
    else if (word == "--buffer" && number(value, 0.0, 5.0, options.policy.buffer_m))
      ++i;
    else if (word == "--frames" && number(value, 1L, 1'000'000'000L, options.frames))
      ++i;
    else
      return false;
  }
  return true;
}

static const char* word(Read read) {
  static const char* const words[] = {"nothing", "listed", "whole", "refused"};
  return words[static_cast<int>(read)];
}

static void print_json(const Image& image, const Plan& plan, const GridGeometry& grid) {
  std::printf("{\"state\": \"fresh\", \"sequence\": %llu, \"synthetic\": %s", static_cast<unsigned long long>(image.sequence),
              image.flags & flag_synthetic ? "true" : "false");
  std::printf(", \"memory\": %s", image.flags & flag_memory ? "true" : "false");
  std::printf(", \"read\": \"%s\", \"fed\": %zu, \"forgot\": %s, \"calculated\": %zu, \"took_us\": %.1f", word(plan.read), plan.fed,
              plan.forgot ? "true" : "false", plan.calculated, plan.took_us);
  if (plan.anew_us > 0) std::printf(", \"anew_us\": %.1f, \"as_anew\": %s", plan.anew_us, plan.as_anew ? "true" : "false");
  if (plan.way.empty()) return void(std::printf(", \"path\": null, \"reason\": \"%s\"}\n", plan.why));
  std::printf(", \"goal_outside\": %s, \"cost_m\": %.3f, \"path\": [", plan.goal_outside ? "true" : "false", plan.cost_m);
  for (size_t i = 0; i < plan.way.size(); ++i) {
    const auto [x, y] = rover_place(grid, plan.way[i]);
    std::printf("%s[%.3f, %.3f]", i ? ", " : "", x, y);
  }
  std::printf("]}\n");
}

static void print_text(const Image& image, const Plan& plan, const FollowedMap& map) {
  std::vector<std::string> lines;
  for (int row = 0; row < map.rows(); ++row) {
    lines.emplace_back();
    for (int column = 0; column < map.columns(); ++column) {
      const int value = map.occupancy({row, column});
      lines.back() += value < 0 ? ' ' : map.speed({row, column}) > 0 ? value > 30 ? ':' : '.' : value < 65 ? '+' : '#';
    }
  }
  for (const Place& place : plan.way) lines[static_cast<size_t>(cell_at(place).row)][static_cast<size_t>(cell_at(place).column)] = 'o';
  for (const std::string& line : lines) std::printf("|%s|\n", line.c_str());
  std::printf("map %llu%s: read %s, %zu cells fed%s, %zu calculated, %.0f us", static_cast<unsigned long long>(image.sequence),
              image.flags & flag_synthetic ? " (synthetic)" : "", word(plan.read), plan.fed, plan.forgot ? " (all costs forgotten)" : "",
              plan.calculated, plan.took_us);
  if (plan.anew_us > 0) std::printf(", anew %.0f us and %s", plan.anew_us, plan.as_anew ? "the same" : "NOT the same");
  if (plan.way.empty()) return void(std::printf("; no way: %s\n", plan.why));
  std::printf("; the way costs %.1f m of free ground%s\n", plan.cost_m,
              plan.goal_outside ? ", to the border: the goal lies outside the map" : "");
}

/// Said once: the map cannot be used, and why.
static void say_state(const Reading& reading, Client& client, bool json) {
  static const char* const words[] = {"fresh", "blind", "stale", "dead"};
  const char* state = words[static_cast<int>(reading.trust)];
  std::string why;
  if (reading.trust == Trust::blind) why = describe(reading.reason);
  if (reading.trust == Trust::dead && client.connection() != Connection::connected) why = client.message();
  if (reading.trust == Trust::stale) why = reading.image ? "the map is old" : "the daemon has not made the map and its changes";
  if (json) return void(std::printf("{\"state\": \"%s\", \"path\": null, \"reason\": \"%s\"}\n", state, why.c_str()));
  std::printf("%s%s%s; no way\n", state, why.empty() ? "" : ": ", why.c_str());
}

static int exit_code(Connection connection) {
  if (connection == Connection::no_permission) return 77;
  return connection == Connection::no_memory ? 71 : 69;
}

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) return std::fputs(usage, stdout), 0;
  Options options;
  if (!parse(argc, argv, options)) return std::fputs(usage, stderr), 64;
  setvbuf(stdout, nullptr, _IOLBF, 0);
  Client client;
  const Client::Topic topics[] = {client.subscribe(options.fused ? "fused" : "occupancy"),
                                  client.subscribe(options.fused ? "fused_changes" : "map_changes")};
  Planner planner(options.goal, options.policy, options.compare);
  Trust said = Trust::fresh;
  double printed = -1e9;
  int without = 0;  // fifths of a second without a daemon
  for (long seen = 0; seen != options.frames;) {
    Reading readings[2];
    const bool set = client.wait_set(topics, readings, std::chrono::milliseconds(200));
    const Reading& worse = readings[1].trust > readings[0].trust ? readings[1] : readings[0];
    if (set) ++seen;
    without = worse.trust == Trust::dead ? without + 1 : 0;
    if (!worse.fresh()) planner.forget();  // no way is told over ground that nobody vouches for
    if (!worse.fresh() && (said != worse.trust || (set && options.json))) say_state(worse, client, options.json);
    said = worse.trust;
    if (without >= 25 && options.frames > 0) return exit_code(client.connection());
    if (!set || !worse.fresh()) continue;
    const Plan plan = planner.plan(*readings[0].image, *readings[1].image);
    const double now = static_cast<double>(readings[0].image->ready_ns) * 1e-9;
    if (options.json) print_json(*readings[0].image, plan, planner.map().grid());
    if (options.json || (now - printed < 0.5 && seen != options.frames)) continue;
    printed = now;
    print_text(*readings[0].image, plan, planner.map());
  }
}
