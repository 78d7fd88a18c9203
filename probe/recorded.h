// recorded.h: what vdisp-probe record says when it is done, with a window or without.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "probe/drive_recorder.h"

namespace vdisp {

void tell_recorded(const DriveRecorder& recorder, const Options& options);

}  // namespace vdisp
