// instructions.cpp: callgrind is told when to look; scripts/bench reads what it wrote.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/instructions.h"

#include <stdexcept>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#endif

namespace vdisp::bench {

#ifdef CALLGRIND_TOGGLE_COLLECT
namespace {

void profile(const std::string& name, const Work& work) {
  if (work.prepare) work.prepare();
  CALLGRIND_START_INSTRUMENTATION;
  CALLGRIND_ZERO_STATS;
  CALLGRIND_TOGGLE_COLLECT;
  work.run();
  CALLGRIND_TOGGLE_COLLECT;
  CALLGRIND_DUMP_STATS_AT(name.c_str());
  CALLGRIND_STOP_INSTRUMENTATION;
}

}  // namespace

void count_instructions(const Result& result, const Work& ours, const Work& peer) {
  if (!RUNNING_ON_VALGRIND) throw std::runtime_error("--instructions counts under valgrind; scripts/bench --instructions does it");
  if (!result.skipped.empty()) return;
  profile(result.contest->name + " ours", ours);
  if (peer.run) profile(result.contest->name + " peer", peer);
}
#else
void count_instructions(const Result&, const Work&, const Work&) {
  throw std::runtime_error("built without valgrind/callgrind.h; install valgrind and build again");
}
#endif

}  // namespace vdisp::bench
