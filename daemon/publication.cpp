// publication.cpp: topics to outlets.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/publication.h"

#include <sysexits.h>

#include "daemon/log/log.h"

namespace vdisp {

std::unique_ptr<SharedMemory> publish(Driver& driver, const Options& options) {
  const Config& config = options.config;
  std::unique_ptr<SharedMemory> shared;
  if (config.main.middleware != "none") {
    TopicList topics;
    for (const Topic& topic : driver.published_topics()) topics.emplace_back(topic.name, topic.spec);
    const ShmOptions wanted{config.main.name, config.ipc.group, static_cast<uint32_t>(config.ipc.memory)};
    try {
      shared = std::make_unique<SharedMemory>(wanted, topics);
    } catch (const ShmError& error) {
      // A recording can be evaluated beside the daemon that serves the rover.
      if (options.dump.empty() || error.exit_code != EX_UNAVAILABLE) throw;
      log::warn("{}; this run only writes {}", error.what(), options.dump);
    }
  }
  driver.connect([&](const std::string& topic, const ImageSpec& spec) -> std::unique_ptr<Outlet> {
    if (shared) return shared->outlet(topic, spec);
    return std::make_unique<BufferOutlet>(spec);
  });
  return shared;
}

}  // namespace vdisp
