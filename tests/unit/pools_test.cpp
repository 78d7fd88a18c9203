// pools_test.cpp: which topics share blocks, and what the segment takes.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/pools.h"

#include <gtest/gtest.h>

#include <sstream>

#include "ipc/records.h"

namespace vdisp {
namespace {

constexpr ImageSpec gray{Pixel::gray8, 0, 640, 480};
constexpr ImageSpec cells{Pixel::count16, 0, 51, 50};

TEST(Pools, topics_of_one_size_share_a_pool) {
  const PoolPlan plan = plan_pools({{"left", gray}, {"right", gray}});
  ASSERT_EQ(plan.pools.size(), 1u);
  EXPECT_EQ(plan.pools[0].block_bytes, 128u + 640 * 480);
  EXPECT_GE(plan.pools[0].count, 2u * 6);  // one in the making, one in the history, two each for two readers
}

TEST(Pools, map_and_decision_share_with_nobody_even_where_the_size_is_the_same) {
  const PoolPlan plan = plan_pools({{"other", cells}, {"map", cells}, {"decision", cells}, {"again", cells}});
  ASSERT_EQ(plan.pools.size(), 3u);
  EXPECT_EQ(plan.topics.at("other"), plan.topics.at("again"));
  EXPECT_NE(plan.topics.at("map"), plan.topics.at("other"));
  EXPECT_NE(plan.topics.at("map"), plan.topics.at("decision"));
  EXPECT_NE(plan.topics.at("decision"), plan.topics.at("other"));
}

TEST(Pools, what_a_planner_follows_is_not_starved_by_another_record_of_its_size) {
  const PoolPlan plan = plan_pools({{"map_changes", record_spec<MapChanges>()}, {"other", record_spec<MapChanges>()}});
  EXPECT_NE(plan.topics.at("map_changes"), plan.topics.at("other"));
}

TEST(Pools, are_ascending_and_every_topic_fits_its_own) {
  const TopicList topics{{"left", gray},   {"heartbeat", record_spec<Heartbeat>()},    {"map", cells},
                         {"limit", cells}, {"floor_model", record_spec<FloorModel>()}, {"catalogue", record_spec<Catalogue>()}};
  const PoolPlan plan = plan_pools(topics);
  for (size_t i = 1; i < plan.pools.size(); ++i) EXPECT_LT(plan.pools[i - 1].block_bytes, plan.pools[i].block_bytes);
  for (const auto& [topic, spec] : topics) EXPECT_GE(plan.pools[plan.topics.at(topic)].block_bytes, spec.bytes()) << topic;
}

TEST(Pools, more_sizes_than_iceoryx_has_pools_still_fit) {
  TopicList topics{{"map", cells}};
  for (uint16_t i = 1; i <= 60; ++i)
    topics.emplace_back(std::string("t").append(std::to_string(i)), ImageSpec{Pixel::gray8, 0, 64, static_cast<uint16_t>(i * 10)});
  const PoolPlan plan = plan_pools(topics);
  EXPECT_LE(plan.pools.size(), 32u);
  for (const auto& [topic, spec] : topics) EXPECT_GE(plan.pools[plan.topics.at(topic)].block_bytes, spec.bytes()) << topic;
}

TEST(Pools, are_printed_with_their_topics_and_the_sum) {
  std::ostringstream out;
  print_pools(out, {{"left", gray}, {"map", cells}});
  EXPECT_NE(out.str().find("pool 307328 bytes x 8 = 2401 KiB: left"), std::string::npos) << out.str();
  EXPECT_NE(out.str().find(": map"), std::string::npos);
  EXPECT_NE(out.str().find("pools together: 3 MiB"), std::string::npos) << out.str();
}

}  // namespace
}  // namespace vdisp
