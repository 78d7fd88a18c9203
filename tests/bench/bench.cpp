// bench.cpp: vdisp-bench: times our stages and OpenCV's in one process on the same images, by turns; scripts/bench builds and runs it.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <thread>

#include "daemon/kernels/kernels.h"
#include "tests/bench/instructions.h"
#include "tests/bench/results.h"
#include "tests/bench/same_work.h"
#include "tests/bench/timing.h"

namespace vdisp::bench {
namespace {

struct Options {
  std::string json;
  std::vector<std::string> only, pairs;
  OurSide side;
  std::vector<int> threads{1, 2};
  bool quick = false, instructions = false, list = false;
};

/// Other work on the machine makes times long, and ratios rough.
void write_load(std::ostream& out) {
  double load = 0;
  const unsigned processors = std::max(1U, std::thread::hardware_concurrency());
  if (getloadavg(&load, 1) == 1 && load > processors + 1)
    out << "the machine had other work (load " << load << " on " << processors << " processors): ratios are rough\n";
}

Images make_images(const Options& options) {
  const int count = options.quick || options.instructions ? 1 : 4;
  Images images{simulated(640, 480, count), simulated(320, 240, count), simulated(1280, 960, 1), {}};
  for (const std::string& pair : options.pairs) {
    const auto parts = CLI::detail::split(pair, ',');
    if (parts.size() < 3) throw std::invalid_argument("--pair " + pair + " is not NAME,LEFT,RIGHT[,CALIBRATION]");
    images.recorded.emplace_back(parts[0], recorded(parts[1], parts[2], parts.size() > 3 ? parts[3] : "", count));
  }
  return images;
}

int run(const Options& options) {
  kernels::kernels(options.side.cpu);  // refuses an unknown level
  const Images images = options.list ? Images{} : make_images(options);
  const std::vector<Contest> all = contests(images, options.side);
  if (options.list) {
    for (const Contest& contest : all) std::cout << contest.name << '\n';
    return 0;
  }
  for (const std::string& name : options.only) {
    if (std::none_of(all.begin(), all.end(), [&](const Contest& c) { return c.name == name; }))
      throw std::invalid_argument("nothing is called '" + name + "'");
  }
  std::vector<Entry> entries = build(all, options.only, options.threads);
  if (options.instructions) {
    for (Entry& entry : entries) count_instructions(entry.result, entry.ours, entry.peer);
    return 0;
  }
  for (Entry& entry : entries) write_same_work(std::cout, entry.result, entry.ours, entry.peer);
  measure(entries, options.quick);
  std::vector<Result> results;
  for (Entry& entry : entries) results.push_back(std::move(entry.result));
  write_table(std::cout, results);
  write_load(std::cout);
  if (options.json.empty()) return 0;
  std::ofstream file(options.json);
  write_json(file, results);
  if (!file.flush()) {
    std::cerr << "bench: " << options.json << " cannot be written\n";
    return 73;
  }
  return 0;
}

}  // namespace
}  // namespace vdisp::bench

int main(int argc, char** argv) {
  vdisp::bench::Options options;
  CLI::App app("Times our stages and OpenCV's by turns, on the same images.", "vdisp-bench");
  app.add_option("--json", options.json, "write a list of {name, threads, ours_ms, peer_ms, ratio}; 0 where there is no peer");
  app.add_option("--only", options.only, "only these names")->delimiter(',');
  app.add_option("--threads", options.threads, "numbers of threads; default 1,2")->delimiter(',')->check(CLI::Range(1, 16));
  app.add_option("--set", options.side.sets, "SECTION.KEY=VALUE for our side of every name, before the name's own")
      ->expected(1)
      ->take_all();
  app.add_option("--cpu", options.side.cpu, "instruction set of our side: auto, plain, ...");
  app.add_option("--pair", options.pairs, "NAME,LEFT,RIGHT[,CALIBRATION]: a rectified recording, timed too")->expected(1)->take_all();
  app.add_flag("--quick", options.quick, "one run of each: does it work?");
  app.add_flag("--list", options.list, "only print the names");
  app.add_flag("--instructions", options.instructions, "under callgrind: one profile for each name and side");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 64;
  }
  try {
    return vdisp::bench::run(options);
  } catch (const std::invalid_argument& error) {
    std::cerr << "bench: " << error.what() << '\n';
    return 64;
  } catch (const std::exception& error) {
    std::cerr << "bench: " << error.what() << '\n';
    return 75;
  }
}
