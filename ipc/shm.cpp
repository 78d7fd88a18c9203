// shm.cpp: RouDi, its segment and the daemon's own runtime in one process: they live and die together.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/shm.h"

#include <sys/file.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <iceoryx_posh/iceoryx_posh_config.hpp>
#include <iceoryx_posh/internal/mepoo/segment_manager.hpp>
#include <iceoryx_posh/roudi/iceoryx_roudi_components.hpp>
#include <iceoryx_posh/runtime/posh_runtime_single_process.hpp>
#include <iostream>
#include <string_view>

#include "ipc/endpoint.h"
#include "ipc/pools.h"
#include "ipc/quiet.h"
#include "ipc/roudi.h"
#include "ipc/shm_check.h"
#include "ipc/shm_outlet.h"

namespace vdisp {

struct SharedMemory::Implementation {
  ShmOptions options;
  PoolPlan plan;
  Rights rights;
  // Never destroyed: their destructors destroy mutexes that readers may still use.
  iox::roudi::IceOryxRouDiComponents* components = nullptr;
  iox::mepoo::MemoryManager* memory = nullptr;
  EmbeddedRoudi* roudi = nullptr;

  void start();
};

namespace {

// What leave() removes: set once, when this process has become the owner.
std::vector<std::string>& own_files() {
  static auto* files = new std::vector<std::string>;
  return *files;
}

/// A name that iceoryx can carry: its messages are separated by commas and cut at 100 characters.
void check_name(const std::string& what, const std::string& name) {
  if (name.empty() || name.size() > 100 || name.find(',') != std::string::npos)
    throw ShmError(78, what + " '" + name + "': a name in shared memory has 1 to 100 characters and no comma");
}

}  // namespace

void SharedMemory::Implementation::start() {
  // A thread that cannot be started ends in terminate(): RouDi's constructors are noexcept.
  const auto before = std::set_terminate([] {
    constexpr std::string_view line =
        "shared memory: iceoryx could not start its threads: no memory, or too many threads (ulimit -v, -u)\n";
    if (write(STDERR_FILENO, line.data(), line.size()) < 0) { /* nobody to tell */
    }
    _exit(71);
  });
  const Muted muted(Who::everybody);
  iox::RouDiConfig_t config;
  iox::mepoo::MePooConfig pools;
  for (const Pool& pool : plan.pools) pools.addMemPool({chunk_payload(pool.block_bytes), pool.count});
  const iox::posix::PosixGroup::string_t group(iox::cxx::TruncateToCapacity, rights.owner_group);
  config.m_sharedMemorySegments.push_back({group, group, pools});
  components = new iox::roudi::IceOryxRouDiComponents(config);
  restrict_segments(rights);
  // Before RouDi's threads: they ask for users and groups too, as readers register, and libc tells both of them in one place.
  auto user = iox::posix::PosixUser::getUserOfCurrentProcess();
  auto segment = components->rouDiMemoryManager.segmentManager().value()->getSegmentInformationWithWriteAccessForUser(user);
  if (!segment.m_memoryManager.has_value())
    throw ShmError(75, "shared memory: iceoryx does not let user and group of this process write; run it with its primary group");
  memory = &segment.m_memoryManager.value().get();
  roudi = new EmbeddedRoudi(components->rouDiMemoryManager, components->portManager);
  new iox::runtime::PoshRuntimeSingleProcess(iox::RuntimeName_t(iox::cxx::TruncateToCapacity, daemon_runtime));
  restrict_sockets(rights);
  std::set_terminate(before);
}

SharedMemory::SharedMemory(const ShmOptions& options, const TopicList& topics) : implementation_(new Implementation) {
  Implementation& self = *implementation_;
  self.options = options;
  check_name("[main] name", options.instance);
  for (const auto& topic : topics) check_name("stage", topic.first);
  self.plan = plan_pools(topics);
  const uint64_t bytes = self.plan.bytes();
  const uint64_t cap = static_cast<uint64_t>(options.memory_mib) << 20;
  if (cap != 0 && bytes > cap)
    throw ShmError(78, "[ipc] memory = " + std::to_string(options.memory_mib) + " MiB is too little for the stages, which need " +
                           std::to_string((bytes + (1u << 20) - 1) >> 20) + ": " + describe(self.plan));
  self.rights = rights_for(options.group);
  check_shared_memory(self.rights, bytes);
  own_files() = files_of(self.rights);
  for (const std::string& lock : locks()) own_files().push_back(lock);
  silence_iceoryx();
  exit_on_fatal_error();
  self.start();
}

SharedMemory::~SharedMemory() = default;

std::unique_ptr<Outlet> SharedMemory::outlet(const std::string& topic, const ImageSpec& spec) {
  const auto& self = *implementation_;
  const auto found = self.plan.topics.find(topic);
  if (found == self.plan.topics.end() || self.plan.pools[found->second].block_bytes < spec.bytes())
    throw ShmError(75, "stage '" + topic + "' is not among the topics that shared memory was made for");
  const auto text = [](const std::string& s) { return iox::capro::IdString_t(iox::cxx::TruncateToCapacity, s); };
  const Muted muted;
  return std::make_unique<ShmOutlet>(iox::capro::ServiceDescription{"vdisp", text(self.options.instance), text(topic)}, spec,
                                     self.plan.pools[found->second].block_bytes, *self.memory, static_cast<uint32_t>(found->second));
}

bool SharedMemory::attachable() noexcept {
  constexpr int64_t longest_silence_ns = 2'000'000'000;  // both threads are at work ten times a second
  EmbeddedRoudi& roudi = *implementation_->roudi;
  roudi.ask();
  return access(management_segment, F_OK) == 0 && roudi.silence_ns() < longest_silence_ns;
}

void SharedMemory::leave(int exit_code) {
  std::cout.flush();
  std::cerr.flush();
  std::fflush(nullptr);
  // Readers keep what they have mapped; the names go, so that the memory is free when they let go.
  for (const std::string& file : own_files()) unlink(file.c_str());
  _exit(exit_code);
}

}  // namespace vdisp
