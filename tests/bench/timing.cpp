// timing.cpp: what slows the machine down has to slow both sides alike.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/timing.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>

namespace vdisp::bench {
namespace {

double run_ms(const Work& work, int threads, int runs = 1) {
  // OpenCV's number of threads is one of the process, ours are the tree's own.
  if (cv::getNumThreads() != threads) cv::setNumThreads(threads);
  std::chrono::duration<double, std::milli> time{};
  for (int i = 0; i < runs; ++i) {
    if (work.prepare) work.prepare();
    const auto start = std::chrono::steady_clock::now();
    work.run();
    time += std::chrono::steady_clock::now() - start;
  }
  return time.count() / runs;
}

/// Other work interrupts a long run more often than a short one: the faster side runs several times for each time that is taken, so
/// that both are exposed alike.
void balance(Entry& entry) {
  double ours = HUGE_VAL, peer = HUGE_VAL;
  for (int i = 0; i < 3; ++i) {
    ours = std::min(ours, run_ms(entry.ours, entry.result.threads));
    if (entry.peer.run) peer = std::min(peer, run_ms(entry.peer, entry.result.threads));
  }
  if (!entry.peer.run) return;
  const auto runs = [](double ratio) { return static_cast<int>(std::clamp(std::round(ratio), 1.0, 50.0)); };
  entry.our_runs = runs(peer / ours);
  entry.peer_runs = runs(ours / peer);
}

/// Each iteration takes one time of ours and one of the peer's, by turns first.
void time_both(benchmark::State& state, Entry& entry) {
  Result& result = entry.result;
  const auto ours = [&] { return run_ms(entry.ours, result.threads, entry.our_runs); };
  bool ours_first = true;
  for (auto _ : state) {
    double mine = 0, other = 0;
    if (ours_first) mine = ours();
    if (entry.peer.run) other = run_ms(entry.peer, result.threads, entry.peer_runs);
    if (!ours_first) mine = ours();
    ours_first = !ours_first;
    result.ours_ms.push_back(mine);
    if (entry.peer.run) result.peer_ms.push_back(other);
    state.SetIterationTime(1e-3 * (mine * entry.our_runs + other * entry.peer_runs));
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

}  // namespace

std::vector<Entry> build(const std::vector<Contest>& all, const std::vector<std::string>& only, const std::vector<int>& threads) {
  std::vector<Entry> entries;
  for (const Contest& contest : all) {
    if (!only.empty() && std::find(only.begin(), only.end(), contest.name) == only.end()) continue;
    for (int number : threads) {
      Entry entry{{&contest, number, {}, {}, {}}, {}, {}};
      try {
        entry.ours = contest.ours(number);
        if (contest.peer) entry.peer = contest.peer(number);
        run_ms(entry.ours, number);
        if (contest.peer) run_ms(entry.peer, number);
      } catch (const std::exception& error) {
        entry.result.skipped = error.what();
      }
      entries.push_back(std::move(entry));
    }
  }
  return entries;
}

void measure(std::vector<Entry>& entries, bool quick) {
  for (Entry& entry : entries) {
    if (!entry.result.skipped.empty()) continue;
    if (!quick) balance(entry);
    const std::string name = entry.result.contest->name + "/threads:" + std::to_string(entry.result.threads);
    benchmark::RegisterBenchmark(name.c_str(), [&entry](benchmark::State& state) { time_both(state, entry); })->UseManualTime();
  }
  // Repetitions of all names in random order: a slow minute of the machine does not fall on one name alone.
  std::vector<std::string> words{"vdisp-bench", "--benchmark_enable_random_interleaving=true"};
  words.push_back(quick ? "--benchmark_repetitions=1" : "--benchmark_repetitions=5");
  words.push_back(quick ? "--benchmark_min_time=0.001" : "--benchmark_min_time=0.4");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  Quiet quiet;
  benchmark::RunSpecifiedBenchmarks(&quiet);
}

}  // namespace vdisp::bench
