// instructions.h: marks for callgrind: a profile of one run of each side, and nothing else.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/results.h"

namespace vdisp::bench {

/// Dumps one profile for each side, with "NAME SIDE" as its trigger. The sides have run once before. Throws std::runtime_error outside
/// valgrind.
void count_instructions(const Result& result, const Work& ours, const Work& peer);

}  // namespace vdisp::bench
