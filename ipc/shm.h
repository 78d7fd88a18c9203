// shm.h: the daemon's side of the shared memory: RouDi embedded, pools sized from the tree, one outlet for each topic.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ipc/outlet.h"

namespace vdisp {

using TopicList = std::vector<std::pair<std::string, ImageSpec>>;

struct ShmOptions {
  std::string instance;     ///< [main] name
  std::string group;        ///< reader group by name; empty: only the daemon's own user reads
  uint32_t memory_mib = 0;  ///< cap on the segment
};

/// Blocks of one size.
struct Pool {
  uint32_t block_bytes, count;
};
/// The pools a tree needs, ascending by size; map and decision have pools of their own.
std::vector<Pool> pools_for(const TopicList& topics);
void print_pools(std::ostream& out, const TopicList& topics);

/// exit_code: 69 another daemon or RouDi, 71 no shared memory, 77 permission, 78 the tree does not fit [ipc] memory. One line.
class ShmError : public std::runtime_error {
 public:
  ShmError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// One per process. There is no clean shutdown of RouDi that attached readers survive: end the process with leave().
class SharedMemory {
 public:
  SharedMemory(const ShmOptions& options, const TopicList& topics);
  ~SharedMemory();
  std::unique_ptr<Outlet> outlet(const std::string& topic, const ImageSpec& spec);
  /// Whether a new reader could attach just now: the socket that it would use is there, and what answers it works. Asks, and judges by
  /// the answers of the last 2 s: call it several times a second, from one thread. No wait.
  bool attachable() noexcept;
  /// Ends the process at once with this exit code, leaving readers unharmed.
  [[noreturn]] static void leave(int exit_code);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace vdisp
