// config_file.h: vdisp.cfg replaced as a whole or not at all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace vdisp {

/// Of a regular file of at most 1 MiB; of all else, and where it cannot be read, nothing. Never waits for a pipe.
std::optional<std::string> read_text(const std::filesystem::path& file);

/// Writes `text` beside the file, reads it back as the daemon would, and puts it in the file's place; `expected` is what the file is
/// thought to hold, and becomes `text`. Otherwise one line of complaint, and the file is as it was. Owner, group and mode are kept;
/// where the group cannot be, the file is closed to groups.
std::string replace_config(const std::filesystem::path& file, std::string& expected, const std::string& text);

}  // namespace vdisp
