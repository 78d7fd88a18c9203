// config_file.cpp: a new file beside the old one, on the disk for good before it takes its name.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/config_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "config/config.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr size_t longest_file = 1 << 20;  // as config/read.cpp has it

/// 0, or errno.
int write_all(int file, const std::string& text) {
  for (size_t done = 0; done < text.size();) {
    const ssize_t size = write(file, text.data() + done, text.size() - done);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return errno;
    done += static_cast<size_t>(size);
  }
  return fsync(file) == 0 ? 0 : errno;
}

/// Owner, group and mode of the file before. A group that is not the daemon's to give is not kept, and then what the mode allows the group
/// was not meant for the daemon's own. 0, or errno.
int take_after(int file, const struct stat& before) {
  mode_t mode = before.st_mode & 07777;
  if (fchown(file, before.st_uid, before.st_gid) != 0) {
    struct stat now {};
    if (before.st_uid != geteuid() || fstat(file, &now) != 0) return errno;
    if (now.st_gid != before.st_gid) mode &= ~static_cast<mode_t>(S_IRWXG | S_ISGID);
  }
  return fchmod(file, mode) == 0 ? 0 : errno;
}

void sync_folder(const fs::path& folder) {
  const int open_folder = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (open_folder < 0) return;
  fsync(open_folder);
  close(open_folder);
}

/// What reading the new file finds wrong.
std::string wrong_with(const fs::path& file) {
  Config config;
  const ConfigReading reading = read_config(file, {}, config);
  if (reading.complaints.empty()) return {};
  return "with the options of the command line left out: " + reading.complaints[0].text;
}

}  // namespace

std::optional<std::string> read_text(const fs::path& file) {
  const int opened = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (opened < 0) return std::nullopt;
  struct stat what {};
  std::string text(longest_file + 1, 0);
  size_t size = 0;
  ssize_t more = fstat(opened, &what) == 0 && S_ISREG(what.st_mode) ? 1 : -1;
  while (more > 0 && size < text.size()) {
    more = read(opened, text.data() + size, text.size() - size);
    if (more > 0) size += static_cast<size_t>(more);
  }
  close(opened);
  if (more < 0 || size > longest_file) return std::nullopt;
  text.resize(size);
  return text;
}

std::string replace_config(const fs::path& named, std::string& expected, const std::string& text) {
  std::error_code error;
  const fs::path file = fs::canonical(named, error);  // a link stays a link
  const auto found = error ? std::nullopt : read_text(file);
  if (!found) return named.string() + ": cannot be read any more; nothing was saved";
  if (*found != expected)
    return named.string() + ": was changed since the daemon read it; nothing was saved: start vdispd again to read it";
  struct stat before {};
  stat(file.c_str(), &before);
  std::string beside = file.string() + ".XXXXXX";
  const int written = mkostemp(beside.data(), O_CLOEXEC);
  if (written < 0) return file.parent_path().string() + ": cannot be written: " + std::strerror(errno) + "; nothing was saved";
  int failed = write_all(written, text);
  if (!failed) failed = take_after(written, before);
  close(written);
  std::string complaint;
  if (failed) complaint = file.string() + ": cannot be written: " + std::strerror(failed) + "; nothing was saved";
  if (complaint.empty()) complaint = wrong_with(beside);
  if (complaint.empty() && rename(beside.c_str(), file.c_str()) != 0)
    complaint = file.string() + ": cannot be replaced: " + std::strerror(errno);
  if (!complaint.empty()) {
    unlink(beside.c_str());
    return complaint;
  }
  sync_folder(file.parent_path());
  expected = text;
  return {};
}

}  // namespace vdisp
