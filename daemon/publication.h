// publication.h: the shared memory of a run, where it is to have one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "daemon/core/driver.h"
#include "daemon/options.h"
#include "ipc/shm.h"

namespace vdisp {

/// For all topics of the tree, which get their outlets from it; without it (null: [main] middleware = none, or this run only dumps while
/// another daemon serves the rover) they are buffers. Throws ShmError.
std::unique_ptr<SharedMemory> publish(Driver& driver, const Options& options);

}  // namespace vdisp
