// failure.h: what ended the daemon, as one line on stderr and an exit code.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

namespace vdisp {

/// Says what was thrown, in one line, and returns its exit code (sysexits.h): 75 for what only a fault of ours can throw.
int explain(std::exception_ptr failure);

}  // namespace vdisp
