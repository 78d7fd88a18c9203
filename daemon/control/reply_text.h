// reply_text.h: texts of fixed size in replies, and who sent something, in words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace vdisp {

/// As much of the text as fits, with a zero at its end.
template <size_t size>
void put(char (&to)[size], std::string_view text) {
  const size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  std::memset(to + length, 0, size - length);
}

/// " by process 12 of user 0"; of the kernel nothing.
inline std::string sent_by(pid_t pid, uid_t uid) {
  return pid == 0 ? std::string() : " by process " + std::to_string(pid) + " of user " + std::to_string(uid);
}

}  // namespace vdisp
