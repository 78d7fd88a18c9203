// gige_knock.h: asks one address whether a GigE camera is there, and which.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "daemon/sources/aravis_list.h"

namespace vdisp {

/// Answers within milliseconds where Aravis' look at all networks takes a second: so a camera that comes back is seen at once. `id` and
/// `physical` stay empty. Waits at most 100 ms.
std::optional<AttachedCamera> knock_at_gige(const std::string& address);

}  // namespace vdisp
