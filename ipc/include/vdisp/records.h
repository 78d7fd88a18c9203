// records.h: the records under the name that planners know; ipc/records.h is installed in its place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../../records.h"  // IWYU pragma: export
