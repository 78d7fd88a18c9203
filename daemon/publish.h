// publish.h: the way out for what the tree makes: shared memory, or buffers where nothing is published.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "ipc/shm.h"

namespace vdisp {

/// Connects the driver. Null: nothing is published, by [main] middleware, or as another daemon owns the shared memory and this run writes a
/// dump or a recording to `files`. Throws ShmError.
std::unique_ptr<SharedMemory> publish(Driver& driver, const Config& config, const std::string& files);

}  // namespace vdisp
