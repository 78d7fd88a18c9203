// no_shm.cpp: stands in until ipc/ has its shared memory; refuses to publish.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include "ipc/shm.h"
namespace vdisp {
struct SharedMemory::Implementation {};
SharedMemory::SharedMemory(const ShmOptions&, const TopicList&) { throw ShmError(71, "this build has no shared memory; middleware = none"); }
SharedMemory::~SharedMemory() = default;
std::unique_ptr<Outlet> SharedMemory::outlet(const std::string&, const ImageSpec&) { return nullptr; }
void SharedMemory::leave(int exit_code) { _exit(exit_code); }
}  // namespace vdisp
