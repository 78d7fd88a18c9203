// results.h: times of both sides, their medians, the table and the JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/bench/contests.h"

namespace vdisp::bench {

struct Result {
  const Contest* contest = nullptr;
  int threads = 1;
  std::vector<double> ours_ms, peer_ms;  ///< one pair of runs after the other; the peer's stay empty where there is none
  std::string skipped;                   ///< why it was not timed

  double ours() const;
  double peer() const;  ///< 0: no peer
  double ratio() const;
  const Asked& asked() const { return threads == 1 ? contest->asked : contest->asked_of_two; }
};

/// Median; 0 of none.
double median(std::vector<double> values);

/// One line a result, and how many reach what is asked of them.
void write_table(std::ostream& out, const std::vector<Result>& results);
/// A list of {"name", "threads", "ours_ms", "peer_ms", "ratio"}; peer_ms and ratio are 0 where there is no peer. What was skipped is not in
/// it.
void write_json(std::ostream& out, const std::vector<Result>& results);

}  // namespace vdisp::bench
