// flight_place.h: whether [recorder] folder can be written, before something happens that is to be written there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace vdisp {

/// Makes the folder. Empty: it can be written; else why not, and what would be right, in one line.
std::string trouble_with_flight_place(const std::filesystem::path& folder);

}  // namespace vdisp
