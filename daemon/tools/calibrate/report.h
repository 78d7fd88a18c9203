// report.h: a solution as a picture: where the corners were, how far off they are, and how the views compare.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/tools/calibrate/stereo_solution.h"

namespace vdisp::calibrate {

/// Throws WriteError.
void write_report(const std::filesystem::path& file, const Solution& solution, const std::vector<View>& views);

}  // namespace vdisp::calibrate
