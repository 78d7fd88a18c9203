// command.h: the messages of the control socket under the name that planners know; ipc/command.h is installed in its place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../../command.h"  // IWYU pragma: export
