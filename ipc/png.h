// png.h: PNG files that are whole or absent: encoded in memory with fixed settings, written beside the place and renamed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdisp {

/// exit_code: 73 the file or folder cannot be created, 74 it cannot be written (disk full). One line.
class WriteError : public std::runtime_error {
 public:
  WriteError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};
/// The error for a failed call on `path`: 74 where the device is full or broken, else 73.
WriteError write_error(const std::string& what, const std::filesystem::path& path, int error_number);

/// The hidden name beside `path` under which it is written until it is complete: DIR/.NAME.part.
std::filesystem::path part_of(const std::filesystem::path& path);

/// What one pixel of a PNG is. gray16 samples are native-endian in memory.
enum class PngKind { gray8, gray16, rgb8 };

/// The same pixels give the same bytes. `row(y)` is asked for each row once, from the top.
std::string encode_png(PngKind kind, int width, int height, const std::function<const void*(int y)>& row);

/// The pixels of a PNG of 8 bit grey and this size. Empty where it was whole, else what is wrong with it; nothing is promised of the rows
/// then.
std::string decode_gray8(std::string_view bytes, int width, int height, const std::function<void*(int y)>& row);

/// Writes a file so that a reader finds the old one, none, or the whole new one. Throws WriteError and leaves nothing behind.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace vdisp
