// tree.h: the processing tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "config/config.h"
#include "daemon/control/inputs.h"
#include "daemon/core/driver.h"
#include "daemon/sources/source.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Adds all stages that the configuration asks for. `machine`, `config` and `inputs` have to outlive the driver: stages work with the
/// first, read live parameters from the second, and show what came into the third.
/// Throws FormatError where sizes, calibration and parameters do not fit together.
void build_tree(Driver& driver, std::unique_ptr<StereoSource> source, Machine& machine, const Config& config, Inputs& inputs);

}  // namespace vdisp
