// map.cpp: vdisp-probe map: the obstacle map in a terminal, also over ssh.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ipc/dump.h"
#include "probe/attach.h"
#include "probe/kept.h"
#include "probe/map_text.h"
#include "probe/readout.h"
#include "probe/terminal.h"

namespace vdisp {
namespace {

using nlohmann::ordered_json;

/// The last map with something on it, and what is to be said of the present.
struct Shown {
  KeptImage map;
  Reading reading;  ///< its image is not to be looked at: it may be gone
  uint64_t sequence = 0;
  bool synthetic = false;
};

void take(Shown& shown, const Reading& reading, const std::string& topic) {
  shown.reading = reading;
  if (!reading.image) return;
  if (reading.image->spec.pixel != Pixel::count16 || !is_grid(topic))
    throw ProbeError(64, "stage '" + topic + "' is no map but " + spec_words(reading.image->spec));
  shown.sequence = reading.image->sequence;
  shown.synthetic = (reading.image->flags & flag_synthetic) != 0;
  if (reading.image->valid()) shown.map.keep(*reading.image);
}

double rounded(double value) { return std::round(value * 1e6) / 1e6; }

std::string json_line(const Shown& shown) {
  const Image* map = shown.reading.fresh() ? shown.map.get() : nullptr;
  ordered_json json{{"state", name(shown.reading.trust)}, {"reason", name(shown.reading.reason)}, {"age_s", rounded(shown.reading.age_s)},
                    {"sequence", shown.sequence},         {"synthetic", shown.synthetic},         {"nearest", nullptr}};
  if (map) {
    if (const auto place = nearest_obstacle(*map))
      json["nearest"] = {{"x", rounded(place->x)},
                         {"z", rounded(place->z)},
                         {"distance", rounded(place->distance())},
                         {"bearing_deg", rounded(place->bearing_deg())}};
    const GridGeometry& grid = map->grid;
    json.update({{"timestamp_ns", map->timestamp_ns},
                 {"columns", map->spec.width},
                 {"rows", map->spec.height},
                 {"cell", rounded(static_cast<double>(grid.cell))},
                 {"origin_row", grid.origin_row},
                 {"origin_column", grid.origin_column},
                 {"min_count", grid.min_count}});
    ordered_json rows = ordered_json::array();
    for (int y = 0; y < map->spec.height; ++y) {
      const int16_t* counts = map->row<int16_t>(y);
      rows.push_back(std::vector<int>(counts, counts + map->spec.width));
    }
    json["counts"] = rows;
  }
  return json.dump() + "\n";
}

std::string state_line(const Shown& shown, bool colour) {
  constexpr const char* inks[] = {"\x1b[1;38;5;114m", "\x1b[1;38;5;221m", "\x1b[1;38;5;215m", "\x1b[1;38;5;203m"};
  const std::string state = state_words(shown.reading);
  char text[96];
  std::snprintf(text, sizeof text, "  frame %llu, %.0f ms old%s", static_cast<unsigned long long>(shown.sequence),
                1000 * shown.reading.age_s, shown.synthetic ? ", synthetic" : "");
  const std::string frame = shown.reading.trust == Trust::fresh ? text : "";
  return colour ? inks[static_cast<int>(shown.reading.trust)] + state + "\x1b[0m" + frame : state + frame;
}

std::string page(const Shown& shown, MapLook look) {
  std::string text;
  const Image* map = shown.map.get();
  look.old = !shown.reading.fresh();
  if (map && (look.colour || !look.old)) {
    for (const std::string& line : map_text(*map, look)) text += line + "\n";
  }
  text += state_line(shown, look.colour) + "\n";
  if (map && shown.reading.fresh())
    text += nearest_words(*map) + "\n";
  else if (map && look.colour)
    text += "the map above is the last that was valid\n";
  return text;
}

constexpr int stage_columns = 28;

/// The stages with their mean times to the right of the page, one on each line from the top, where the terminal has room for them.
std::string beside(const std::string& page, const std::vector<CatalogueEntry>& stages, const LiveScreen& screen) {
  std::vector<std::string> side;
  for (size_t i = 0; i < stages.size(); ++i) {
    if (i > 0 && stages[i].stage == stages[i - 1].stage) continue;
    char text[64];
    std::snprintf(text, sizeof text, stages[i].runs ? "%-16.16s%7.1f ms" : "%-16.16s  asleep", stages[i].name,
                  static_cast<double>(stages[i].mean_ns) * 1e-6);
    side.push_back(text);
  }
  std::string joined;
  size_t line = 0;
  for (size_t begin = 0; begin < page.size();) {
    const size_t end = std::min(page.find('\n', begin), page.size());
    joined += page.substr(begin, end - begin);
    if (line < side.size())
      joined += "\x1b[" + std::to_string(screen.columns() - stage_columns + 2) + "G\x1b[38;5;245m" + side[line] + "\x1b[0m";
    joined += "\n";
    ++line;
    begin = end + 1;
  }
  return joined;
}

/// A page for a person at a terminal.
std::string live_page(Client& client, const Shown& shown, const LiveScreen& screen) {
  const bool room = screen.columns() >= 72;
  const int columns = screen.columns() - 6 - (room ? stage_columns : 0);
  const std::string text = page(shown, {columns, screen.rows() - 4, true, utf8_terminal(), false});
  return (room ? beside(text, client.topics(Client::Time(0)), screen) : text) + "q ends";
}

int print_once(Client& client, const std::string& name, const Options& options) {
  const Client::Topic topic = client.subscribe(name);
  Shown shown;
  for (int tries = 0; tries < 50 && !stopped(); ++tries) {
    take(shown, client.wait(topic, Client::Time(100)), name);
    if (!shown.reading.image || shown.reading.trust == Trust::stale) continue;
    const bool colour = isatty(STDOUT_FILENO) == 1;
    print(options.json ? json_line(shown) : page(shown, {0, 0, colour, colour && utf8_terminal(), false}));
    return 0;
  }
  if (stopped()) return 0;
  throw ProbeError(69, "no image of stage '" + name + "' came within 5 s; see vdisp-probe list and vdisp-probe stats");
}

}  // namespace

int map(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  const std::string name = options.topics.empty() ? "map" : options.topics.front();
  require(topics_of(client), name);
  if (options.once) return print_once(client, name, options);
  const Client::Topic topic = client.subscribe(name);
  Shown shown;
  LiveScreen screen;
  auto last = std::chrono::steady_clock::time_point();
  while (!stopped()) {
    const char key = screen.key(screen.live() ? 100 : 50);
    if (key == 'q' || key == 27) break;
    take(shown, client.wait(topic, Client::Time(100)), name);
    const auto now = std::chrono::steady_clock::now();
    if (!screen.live() && now - last < std::chrono::seconds(1)) continue;
    last = now;
    if (options.json)
      screen.show(json_line(shown));
    else if (screen.live())
      screen.show(live_page(client, shown, screen));
    else
      screen.show(page(shown, {}));
  }
  return 0;
}

}  // namespace vdisp
