// failure.h: what ended the daemon, as one line on stderr and an exit code.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <functional>

namespace vdisp {

/// Says what was thrown, in one line, and returns its exit code (sysexits.h): 75 for what only a fault of ours can throw.
int explain(std::exception_ptr failure);
/// What `act` throws becomes the failure where there is none yet: the first one tells what happened.
void attempt(std::exception_ptr& failure, const std::function<void()>& act);

}  // namespace vdisp
