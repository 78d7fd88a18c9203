// timing.h: both sides of each contest run by turns, under Google Benchmark.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/results.h"

namespace vdisp::bench {

/// One contest with one number of threads.
struct Entry {
  Result result;
  Work ours, peer;
  int our_runs = 1, peer_runs = 1;  ///< that make one time
};

/// Builds both sides of what is asked for and runs them; with what failed, `skipped` says why. The contests have to outlive the entries.
std::vector<Entry> build(const std::vector<Contest>& all, const std::vector<std::string>& only, const std::vector<int>& threads);
/// Fills the results. `quick`: one time for each.
void measure(std::vector<Entry>& entries, bool quick);

}  // namespace vdisp::bench
