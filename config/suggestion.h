// suggestion.h: what was probably meant by a name that is not in the table.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace vdisp {

/// Letters to insert, delete or change, or neighbours to swap, upper and lower case being the same.
size_t edit_distance(std::string_view a, std::string_view b);
/// Empty where nothing is near.
std::string_view nearest_section(std::string_view name);
/// The whole complaint.
std::string unknown_section(std::string_view name);
std::string unknown_key(std::string_view section, std::string_view key);
/// "[Map]", "[Map] or [sim]": the sections that have this key; empty where none has.
std::string sections_with(std::string_view key);

}  // namespace vdisp
