// planner.cpp: a small planner: reads the map, says where the nearest obstacle is and which way is free, and outlives the daemon.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "vdisp/client.h"

using namespace vdisp;

struct View {
  double range = INFINITY, bearing = 0, free_heading = NAN;  // m, rad, positive to the right
};

/// The nearest obstacle, and the heading nearest to straight ahead that has 2 m of room for a rover 0.6 m wide.
static View look(const Image& map) {
  View view;
  const GridGeometry& grid = map.grid;
  const auto each_obstacle = [&](auto&& visit) {
    for (int row = 0; row < map.spec.height; ++row) {
      for (int column = 0; column < map.spec.width; ++column) {
        if (static_cast<uint32_t>(map.row<int16_t>(row)[column]) < grid.min_count) continue;
        visit((column + 0.5 - double{grid.origin_column}) * grid.cell, (double{grid.origin_row} - row - 0.5) * grid.cell);
      }
    }
  };
  each_obstacle([&](double x, double z) {
    if (std::hypot(x, z) >= view.range) return;
    view.range = std::hypot(x, z);
    view.bearing = std::atan2(x, z);
  });
  for (int step = 0; step <= 10 && std::isnan(view.free_heading); ++step) {
    for (double heading : {step * 0.05, -step * 0.05}) {  // to 0.5 rad on either side
      bool free = true;
      each_obstacle([&](double x, double z) {
        const double along = x * std::sin(heading) + z * std::cos(heading), beside = x * std::cos(heading) - z * std::sin(heading);
        if (along > 0 && along < 2 && std::abs(beside) < 0.3) free = false;
      });
      if (free && std::isnan(view.free_heading)) view.free_heading = heading;
    }
  }
  return view;
}

int main(int argc, char** argv) {
  const long frames = argc == 3 && std::strcmp(argv[1], "--frames") == 0 ? std::atol(argv[2]) : -1;
  if (argc != 1 && frames <= 0) {
    std::fprintf(stderr, "usage: vdisp-planner [--frames N]   N maps, then end; without it: for ever\n");
    return 64;
  }
  setvbuf(stdout, nullptr, _IOLBF, 0);
  Client client;
  const Client::Topic topic = client.subscribe("map");
  const char* const words[] = {"fresh", "blind", "stale", "dead"};
  int last = -1;
  uint64_t epoch = 0;
  double printed = -1e9;
  for (long seen = 0; seen != frames;) {
    const Reading reading = client.wait(topic, std::chrono::milliseconds(200));
    if (client.epoch() != 0 && client.epoch() != epoch) {  // a daemon that has just started: forget all that the old one said
      epoch = client.epoch();
      std::printf("epoch %llu: reading everything anew\n", static_cast<unsigned long long>(epoch));
    }
    if (static_cast<int>(reading.trust) != last) {
      last = static_cast<int>(reading.trust);
      const bool lost = reading.trust == Trust::dead && client.connection() != Connection::connected;
      const std::string why = reading.trust == Trust::blind ? std::string(describe(reading.reason)) : lost ? client.message() : "";
      std::printf("%s%s%s\n", words[last], why.empty() ? "" : ": ", why.c_str());
    }
    if (!reading.fresh()) continue;  // stop, and wait
    ++seen;
    const double now = static_cast<double>(reading.image->ready_ns) * 1e-9;
    if (now - printed < 0.2 && seen != frames) continue;  // 5 lines a second are enough to read
    printed = now;
    const View view = look(*reading.image);
    std::printf("map %llu%s: ", static_cast<unsigned long long>(reading.image->sequence),
                reading.image->flags & flag_synthetic ? " (synthetic)" : "");
    if (std::isfinite(view.range)) std::printf("nearest obstacle %.2f m at %+.0f deg, ", view.range, view.bearing * 180 / M_PI);
    if (std::isnan(view.free_heading))
      std::printf("no way is free\n");
    else
      std::printf("free heading %+.0f deg\n", view.free_heading * 180 / M_PI);
  }
}
