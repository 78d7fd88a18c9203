// same_work.h: do both sides do the same? No speed counts without it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>

#include "tests/bench/results.h"

namespace vdisp::bench {

/// One line on how the last results of the two sides differ: grey levels of views, density and agreement of disparities.
void write_same_work(std::ostream& out, const Result& result, const Work& ours, const Work& peer);

}  // namespace vdisp::bench
