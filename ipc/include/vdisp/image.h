// image.h: the image under the name that planners know; ipc/image.h is installed in its place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../../image.h"  // IWYU pragma: export
