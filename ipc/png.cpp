// png.cpp: libpng into memory; POSIX write and close, whose errors the C++ streams would hide.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/png.h"

#include <fcntl.h>
#include <png.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>

namespace vdisp {
namespace {

void append(png_structp png, png_bytep data, size_t length) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), length);
}

void nothing_to_flush(png_structp) {}

[[noreturn]] void refuse(png_structp, const char* message) {
  throw WriteError(std::strstr(message, "memory") ? 71 : 75, std::string("libpng: ") + message);
}

}  // namespace

std::filesystem::path part_of(const std::filesystem::path& path) {
  return path.parent_path() / std::string(1, '.').append(path.filename().string()).append(".part");
}

WriteError write_error(const std::string& what, const std::filesystem::path& path, int error_number) {
  const bool device = error_number == ENOSPC || error_number == EDQUOT || error_number == EIO || error_number == EFBIG;
  std::string advice;
  if (error_number == ENOSPC || error_number == EDQUOT) advice = "; free some space or name another folder";
  if (error_number == EROFS || error_number == EACCES || error_number == EPERM) advice = "; name a folder that you may write to";
  return {device ? 74 : 73, what + " " + path.string() + ": " + std::strerror(error_number) + advice};
}

std::string encode_png(PngKind kind, int width, int height, const std::function<const void*(int)>& row) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, refuse, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info) throw WriteError(71, "libpng: insufficient memory");
  try {
    png_set_write_fn(png, &bytes, append, nothing_to_flush);
    png_set_IHDR(png, info, width, height, kind == PngKind::gray16 ? 16 : 8,
                 kind == PngKind::rgb8 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 2);  // dumps of a thousand frames: speed before size
    png_set_filter(png, 0, PNG_FILTER_SUB);
    png_write_info(png, info);
    if (kind == PngKind::gray16 && std::endian::native == std::endian::little) png_set_swap(png);
    for (int y = 0; y < height; ++y) png_write_row(png, static_cast<png_const_bytep>(row(y)));
    png_write_end(png, nullptr);
  } catch (...) {
    png_destroy_write_struct(&png, &info);
    throw;
  }
  png_destroy_write_struct(&png, &info);
  return bytes;
}

namespace {

struct Unread {
  std::string_view bytes;
};

void take(png_structp png, png_bytep data, size_t length) {
  auto& unread = *static_cast<Unread*>(png_get_io_ptr(png));
  if (unread.bytes.size() < length) png_error(png, "is truncated");
  std::memcpy(data, unread.bytes.data(), length);
  unread.bytes.remove_prefix(length);
}

[[noreturn]] void give_up(png_structp, const char* message) { throw std::runtime_error(message); }
void pass_over(png_structp, const char*) {}

}  // namespace

std::string decode_gray8(std::string_view bytes, int width, int height, const std::function<void*(int)>& row) {
  Unread unread{bytes};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, give_up, pass_over);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  std::string fault = info ? "" : "libpng: out of memory";
  try {
    if (fault.empty()) {
      png_set_read_fn(png, &unread, take);
      png_read_info(png, info);
      const bool gray8 = png_get_color_type(png, info) == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png, info) == 8 &&
                         png_get_interlace_type(png, info) == PNG_INTERLACE_NONE;
      const auto found_width = png_get_image_width(png, info), found_height = png_get_image_height(png, info);
      if (!gray8) {
        fault = "is not 8 bit grey";
      } else if (found_width != static_cast<uint32_t>(width) || found_height != static_cast<uint32_t>(height)) {
        fault = "is " + std::to_string(found_width) + "x" + std::to_string(found_height) + ", not " + std::to_string(width) + "x" +
                std::to_string(height);
      } else {
        for (int y = 0; y < height; ++y) png_read_row(png, static_cast<png_bytep>(row(y)), nullptr);
        png_read_end(png, nullptr);
      }
    }
  } catch (const std::runtime_error& error) {
    fault = std::string("is damaged: ") + error.what();
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return fault;
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  const std::filesystem::path part = part_of(path);
  const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) throw write_error("cannot create", path, errno);
  int error = 0;
  while (!bytes.empty() && !error) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written > 0)
      bytes.remove_prefix(static_cast<size_t>(written));
    else if (written == 0)
      error = ENOSPC;
    else if (errno != EINTR)
      error = errno;
  }
  if (close(file) != 0 && !error && errno != EINTR) error = errno;
  if (!error && rename(part.c_str(), path.c_str()) == 0) return;
  const WriteError reported = error ? write_error("cannot write", path, error) : write_error("cannot create", path, errno);
  unlink(part.c_str());
  throw reported;
}

}  // namespace vdisp
