// change.h: one parameter of a running daemon set by its name, and vdisp.cfg written anew with what was changed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "config/parameters.h"

namespace vdisp {

/// The row of "SECTION.KEY" or, where one section alone has it, of "KEY". Null: `complaint` holds one line, with the nearest known name.
const Parameter* named_parameter(std::string_view name, std::string& complaint);

/// Sets one value, written as in vdisp.cfg, in a configuration that is whole. The complaint, in the words that reading the file has
/// for it; then `config` is unchanged. Empty: it was set.
std::string change(Config& config, const Parameter& row, std::string_view raw);

/// The text of a vdisp.cfg with these values: each line that has one of the keys gets the new value and keeps its comment, a key that
/// no line has is added behind the last one of its section, and nothing else is touched. angRot stands for both its sections.
std::string rewritten(std::string_view text, std::span<const std::pair<const Parameter*, std::string>> values);

}  // namespace vdisp
