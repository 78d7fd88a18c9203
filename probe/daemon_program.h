// daemon_program.h: which vdispd the probe starts, for replay and compare.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdisp {

/// The program vdispd beside this one, where there is one that may be run; else the name alone, for $PATH.
std::string daemon_program();

}  // namespace vdisp
