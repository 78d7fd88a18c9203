// bench.cpp: vdisp-bench: times our stages and OpenCV's in one process on the same images, by turns; scripts/bench builds and runs it.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <opencv2/core.hpp>

#include "daemon/kernels/kernels.h"
#include "tests/bench/instructions.h"
#include "tests/bench/results.h"
#include "tests/bench/same_work.h"

namespace vdisp::bench {
namespace {

struct Options {
  std::string json;
  std::vector<std::string> only, pairs;
  OurSide side;
  std::vector<int> threads{1, 2};
  bool quick = false, instructions = false, list = false;
};

double run_ms(const Work& work, int threads) {
  // OpenCV's number of threads is one of the process, ours are the tree's own.
  if (cv::getNumThreads() != threads) cv::setNumThreads(threads);
  if (work.prepare) work.prepare();
  const auto start = std::chrono::steady_clock::now();
  work.run();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Each iteration is one run of ours and one of the peer's, by turns first: what slows the machine down slows both.
void time_both(benchmark::State& state, Result& result, const Work& ours, const Work& peer) {
  bool ours_first = true;
  for (auto _ : state) {
    double mine = 0, other = 0;
    if (ours_first) mine = run_ms(ours, result.threads);
    if (peer.run) other = run_ms(peer, result.threads);
    if (!ours_first) mine = run_ms(ours, result.threads);
    ours_first = !ours_first;
    result.ours_ms.push_back(mine);
    if (peer.run) result.peer_ms.push_back(other);
    state.SetIterationTime(1e-3 * (mine + other));
  }
  state.counters["ours_ms"] = result.ours();
  state.counters["peer_ms"] = result.peer();
  state.counters["ratio"] = result.ratio();
}

/// The table follows when all is measured.
class Quiet final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>&) override {}
};

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

/// One place for each contest and number of threads; both sides are built and run once.
struct Entry {
  Result result;
  Work ours, peer;
};

std::vector<Entry> build(const std::vector<Contest>& all, const Options& options) {
  std::vector<Entry> entries;
  for (const Contest& contest : all) {
    if (!options.only.empty() && std::find(options.only.begin(), options.only.end(), contest.name) == options.only.end()) continue;
    for (int threads : options.threads) {
      Entry entry{{&contest, threads, {}, {}, {}}, {}, {}};
      try {
        entry.ours = contest.ours(threads);
        if (contest.peer) entry.peer = contest.peer(threads);
        run_ms(entry.ours, threads);
        if (contest.peer) run_ms(entry.peer, threads);
      } catch (const std::exception& error) {
        entry.result.skipped = error.what();
      }
      entries.push_back(std::move(entry));
    }
  }
  return entries;
}

void measure(std::vector<Entry>& entries, const Options& options) {
  for (Entry& entry : entries) {
    if (!entry.result.skipped.empty()) continue;
    const std::string name = entry.result.contest->name + "/threads:" + std::to_string(entry.result.threads);
    benchmark::RegisterBenchmark(name.c_str(), [&entry](benchmark::State& state) {
      time_both(state, entry.result, entry.ours, entry.peer);
    })->UseManualTime();
  }
  // Repetitions of all names in random order: a slow minute of the machine does not fall on one name alone.
  std::vector<std::string> words{"vdisp-bench", "--benchmark_enable_random_interleaving=true"};
  words.push_back(options.quick ? "--benchmark_repetitions=1" : "--benchmark_repetitions=5");
  words.push_back(options.quick ? "--benchmark_min_time=0.001" : "--benchmark_min_time=0.4");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  Quiet quiet;
  benchmark::RunSpecifiedBenchmarks(&quiet);
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
  std::vector<Entry> entries = build(all, options);
  if (options.instructions) {
    for (Entry& entry : entries) count_instructions(entry.result, entry.ours, entry.peer);
    return 0;
  }
  for (Entry& entry : entries) write_same_work(std::cout, entry.result, entry.ours, entry.peer);
  measure(entries, options);
  std::vector<Result> results;
  for (Entry& entry : entries) results.push_back(std::move(entry.result));
  write_table(std::cout, results);
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
