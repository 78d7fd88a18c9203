// shm_check.h: what has to hold before RouDi starts, because iceoryx would abort or corrupt where it does not.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace vdisp {

inline const std::string daemon_runtime = "vdispd";

struct Rights {
  std::string owner_group;                 ///< primary group of the daemon's user: iceoryx names the segment after it
  gid_t readers = static_cast<gid_t>(-1);  ///< -1: nobody but the user
};

/// Sockets and segments that a daemon makes, and the locks that iceoryx holds while it lives.
std::vector<std::string> files_of(const Rights& rights);
std::vector<std::string> locks();
/// Throws ShmError 78 for a group that is unknown, 77 for one that the daemon may not give files to.
Rights rights_for(const std::string& reader_group);
/// Throws ShmError: 69 somebody else is RouDi, 77 leftovers of another user or no permission, 71 no room for `bytes`.
void check_shared_memory(const Rights& rights, uint64_t bytes);
/// Owner writes, `readers` read the images and may register; nobody else can do anything. Throws ShmError 77.
void restrict_segments(const Rights& rights);
void restrict_sockets(const Rights& rights);

}  // namespace vdisp
