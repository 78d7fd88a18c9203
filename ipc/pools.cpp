// pools.cpp: pools are shared by block size; what a planner steers by gets sizes of its own, so that no viewer can starve it.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/pools.h"

#include <algorithm>
#include <array>
#include <iceoryx_posh/iceoryx_posh_types.hpp>
#include <iceoryx_posh/mepoo/chunk_header.hpp>
#include <set>
#include <sstream>

namespace vdisp {
namespace {

constexpr std::array<std::string_view, 13> own_pool{"map",       "occupancy", "map_changes", "fused", "fused_changes",
                                                    "memory",    "tracks",    "decision",    "drive", "floor_model",
                                                    "catalogue", "heartbeat", "health"};

// One in the making, one in the history, and for three readers the two they hold; the queue holds the same newest ones.
constexpr uint32_t blocks_per_topic = 8;
constexpr uint32_t blocks_of_own = 32;

bool wants_own(const std::string& topic) { return std::find(own_pool.begin(), own_pool.end(), topic) != own_pool.end(); }

}  // namespace

uint32_t chunk_payload(uint32_t block_bytes) {
  const uint32_t padding = 64 - static_cast<uint32_t>(alignof(iox::mepoo::ChunkHeader));
  return (block_bytes + padding + 7u) & ~7u;
}

PoolPlan plan_pools(const TopicList& topics) {
  std::map<uint32_t, std::pair<uint32_t, std::vector<std::string>>> by_size;  // size -> blocks, topics
  for (const auto& [topic, spec] : topics) {
    if (wants_own(topic)) continue;
    auto& [blocks, names] = by_size[spec.bytes()];
    blocks += blocks_per_topic;
    names.push_back(topic);
  }
  const size_t own = static_cast<size_t>(std::count_if(topics.begin(), topics.end(), [](const auto& t) { return wants_own(t.first); }));
  while (by_size.size() + own > iox::MAX_NUMBER_OF_MEMPOOLS) {  // the smallest wastes least in the next
    auto smallest = by_size.extract(by_size.begin());
    auto& [blocks, names] = by_size.begin()->second;
    blocks += smallest.mapped().first;
    names.insert(names.end(), smallest.mapped().second.begin(), smallest.mapped().second.end());
  }
  for (const auto& [topic, spec] : topics) {
    if (!wants_own(topic)) continue;
    uint32_t size = spec.bytes();
    while (by_size.count(size)) size += 64;
    by_size[size] = {blocks_of_own, {topic}};
  }
  PoolPlan plan;
  for (const auto& [size, content] : by_size) {
    for (const std::string& topic : content.second) plan.topics[topic] = plan.pools.size();
    plan.pools.push_back({size, content.first});
  }
  return plan;
}

uint64_t PoolPlan::bytes() const {
  uint64_t sum = 0;
  for (const Pool& pool : pools)
    sum += static_cast<uint64_t>(pool.count) * (chunk_payload(pool.block_bytes) + sizeof(iox::mepoo::ChunkHeader));
  return sum;
}

std::string describe(const PoolPlan& plan) {
  std::ostringstream text;
  for (size_t i = 0; i < plan.pools.size(); ++i) {
    text << (i ? ", " : "") << plan.pools[i].count << " x " << plan.pools[i].block_bytes << " bytes (";
    const char* comma = "";
    for (const auto& [topic, pool] : plan.topics) {
      if (pool != i) continue;
      text << comma << topic;
      comma = " ";
    }
    text << ")";
  }
  return text.str();
}

std::vector<Pool> pools_for(const TopicList& topics) { return plan_pools(topics).pools; }

void print_pools(std::ostream& out, const TopicList& topics) {
  const PoolPlan plan = plan_pools(topics);
  for (size_t i = 0; i < plan.pools.size(); ++i) {
    const Pool& pool = plan.pools[i];
    out << "pool " << pool.block_bytes << " bytes x " << pool.count << " = "
        << (static_cast<uint64_t>(pool.block_bytes) * pool.count + 1023) / 1024 << " KiB:";
    for (const auto& [topic, index] : plan.topics) {
      if (index == i) out << ' ' << topic;
    }
    out << '\n';
  }
  out << "pools together: " << (plan.bytes() + (1u << 20) - 1) / (1u << 20) << " MiB\n";
}

}  // namespace vdisp
