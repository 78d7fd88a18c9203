// pools.h: which topic takes its blocks from which pool.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "ipc/shm.h"

namespace vdisp {

struct PoolPlan {
  std::vector<Pool> pools;               ///< ascending by size
  std::map<std::string, size_t> topics;  ///< index into pools
  /// What the segment takes, with iceoryx's headers.
  uint64_t bytes() const;
};
PoolPlan plan_pools(const TopicList& topics);
/// "12 x 307328 bytes (left, right), ..."
std::string describe(const PoolPlan& plan);
/// The size iceoryx has to be given so that one loan of block_bytes, aligned to 64, fits exactly.
uint32_t chunk_payload(uint32_t block_bytes);

}  // namespace vdisp
