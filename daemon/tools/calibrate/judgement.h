// judgement.h: whether a calibration is usable, and which views would make it better.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "daemon/tools/calibrate/stereo_solution.h"

namespace vdisp::calibrate {

/// Fills in cells, faults and advice.
void judge(Solution& solution, const std::vector<View>& views, double most_rms);

/// Its faults and what would make it usable, in one line.
std::string refusal(const Solution& solution);

}  // namespace vdisp::calibrate
