// tree.h: the processing tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/sources/source.h"

namespace vdisp {

/// Adds all stages that the configuration asks for. `config` has to outlive the driver: stages read live parameters from it.
/// Throws FormatError where sizes, calibration and parameters do not fit together.
void build_tree(Driver& driver, std::unique_ptr<StereoSource> source, const Config& config);

}  // namespace vdisp
