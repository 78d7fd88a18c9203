// frame_pairs_test.cpp: which frames are pairs, and when they were taken.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/frame_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <vector>

#include "daemon/sources/camera_clock.h"

namespace vdisp {
namespace {

constexpr int64_t ms = 1'000'000, frame = 33'333'333;

TEST(FramePairs, pair_what_was_taken_together) {
  FramePairs pairs(5 * ms, PairBy::time);
  for (int64_t i = 0; i < 100; ++i) {
    pairs.add(0, {i * frame, 0, 0});
    EXPECT_FALSE(pairs.take());
    pairs.add(1, {i * frame + 2 * ms, 0, 1});
    const auto pair = pairs.take();
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->left.when_ns, i * frame);
    EXPECT_EQ(pair->right.when_ns, i * frame + 2 * ms);
  }
  EXPECT_EQ(pairs.tally().pairs, 100u);
  EXPECT_EQ(pairs.tally().unpaired[0] + pairs.tally().unpaired[1], 0u);
}

TEST(FramePairs, never_join_frames_of_different_exposures_when_one_is_lost) {
  FramePairs pairs(500 * ms, PairBy::time);  // the tolerance is no excuse: half a period ends it
  int wrong = 0, found = 0;
  for (int64_t i = 0; i < 200; ++i) {
    if (i % 7 != 3) pairs.add(0, {i * frame, 0, 0});
    if (i % 5 != 2) pairs.add(1, {i * frame + ms, 0, 1});
    if (const auto pair = pairs.take()) {
      ++found;
      wrong += pair->right.when_ns - pair->left.when_ns != ms;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(found, 130);
}

TEST(FramePairs, give_out_the_newest_and_never_an_older_one_after_it) {
  FramePairs pairs(5 * ms, PairBy::time);
  for (int64_t i = 0; i < 3; ++i) pairs.add(0, {i * frame, 0, static_cast<int>(i)});
  for (int64_t i = 0; i < 3; ++i) pairs.add(1, {i * frame, 0, 10 + static_cast<int>(i)});
  const auto pair = pairs.take();
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->left.slot, 2);
  EXPECT_EQ(pair->right.slot, 12);
  EXPECT_FALSE(pairs.take());
  std::set<int> free;
  for (int slot = pairs.take_free(); slot >= 0; slot = pairs.take_free()) free.insert(slot);
  EXPECT_EQ(free, (std::set<int>{0, 1, 10, 11}));
  EXPECT_EQ(pairs.tally().unpaired[0], 2u);
}

TEST(FramePairs, refuse_times_that_repeat_or_go_back_until_they_stay) {
  FramePairs pairs(5 * ms, PairBy::time);
  pairs.add(0, {1000 * ms, 0, 0});
  pairs.add(0, {1000 * ms, 0, 1});
  pairs.add(0, {900 * ms, 0, 2});
  EXPECT_EQ(pairs.tally().refused[0], 2u);
  pairs.add(1, {900 * ms, 0, 3});
  EXPECT_FALSE(pairs.take());
  for (int64_t i = 1; i < 30; ++i) {
    pairs.add(0, {i * frame, 0, 0});
    pairs.add(1, {900 * ms + i * frame, 0, 1});
  }
  EXPECT_LE(pairs.tally().refused[0], 12u);  // then the clock is believed to have been set
}

TEST(FramePairs, say_how_far_two_free_running_cameras_are_apart) {
  FramePairs pairs(5 * ms, PairBy::time);
  for (int64_t i = 0; i < 10; ++i) {
    pairs.add(0, {i * frame, 0, 0});
    pairs.add(1, {i * frame + 12 * ms, 0, 1});
    EXPECT_FALSE(pairs.take());
  }
  ASSERT_TRUE(pairs.apart_ns());
  EXPECT_EQ(*pairs.apart_ns(), 12 * ms);
}

TEST(FramePairs, by_count_hold_over_lost_frames_and_late_clocks) {
  FramePairs pairs(5 * ms, PairBy::count);
  int found = 0;
  for (uint64_t i = 0; i < 100; ++i) {
    const auto when = static_cast<int64_t>(i) * frame;
    if (i % 3 != 1) pairs.add(0, {when, 7 + i, 0});
    if (i % 4 != 1) pairs.add(1, {when + (i > 20 ? 8 : 1) * ms, 1000 + i, 1});  // stamped later than it was, within twice the tolerance
    while (const auto pair = pairs.take()) {
      ++found;
      EXPECT_EQ(pair->right.count - pair->left.count, 993u);
    }
  }
  EXPECT_GE(found, 49);
}

TEST(FramePairs, by_count_hold_while_a_clock_is_off_by_half_a_period) {
  FramePairs pairs(5 * ms, PairBy::count);
  int found = 0;
  for (uint64_t i = 0; i < 50; ++i) {
    const auto when = static_cast<int64_t>(i) * frame;
    pairs.add(0, {when, i, 0});
    pairs.add(1, {when + (i > 9 && i < 40 ? 17 : 1) * ms, i, 1});
    if (const auto pair = pairs.take()) found += pair->right.count == pair->left.count;
  }
  EXPECT_EQ(found, 50);
}

/// Pairs of one moment among the last 20 of 60, where the right camera counts anew from the 20th frame on: told of it, or not.
int pairs_after_counting_anew(bool told) {
  FramePairs pairs(5 * ms, PairBy::count);
  int late = 0;
  for (uint64_t i = 0; i < 60; ++i) {
    const auto when = static_cast<int64_t>(i) * frame;
    pairs.add(0, {when, i, 0});
    pairs.add(1, {when, i < 20 ? i : i - 20, 1});
    if (const auto pair = pairs.take()) {
      late += i >= 40 && pair->left.when_ns == pair->right.when_ns;
      if (told) {
        EXPECT_EQ(pair->left.when_ns, pair->right.when_ns);
      }
    }
    if (told && i == 19) pairs.restart(1);
  }
  return late;
}

TEST(FramePairs, by_count_find_together_again_when_a_camera_counts_anew_unnoticed) { EXPECT_EQ(pairs_after_counting_anew(false), 20); }

TEST(FramePairs, by_count_begin_anew_when_a_camera_counts_from_zero) { EXPECT_EQ(pairs_after_counting_anew(true), 20); }

TEST(CameraClock, tells_our_time_of_a_clock_that_drifts_within_a_millisecond) {
  CameraClock clock;
  int64_t worst = 0;
  for (int64_t i = 0; i < 3000; ++i) {
    const int64_t taken = 1'000'000 * ms + i * frame;
    const int64_t camera = 5 * ms + i * frame + i * frame / 20000;  // 50 ppm fast
    const int64_t delay = ms + (i * 7919 % 100) * ms / 10;          // 1 to 11 ms on the way
    const int64_t when = clock.when(camera, taken + delay);
    EXPECT_LE(when, taken + delay);
    if (i > 100) worst = std::max<int64_t>(worst, std::llabs(when - taken - ms));
  }
  EXPECT_LT(worst, ms);
}

TEST(CameraClock, begins_anew_after_a_jump) {
  CameraClock clock;
  clock.when(0, 100 * ms);
  EXPECT_EQ(clock.when(frame, 100 * ms + frame), 100 * ms + frame);
  EXPECT_EQ(clock.when(3600'000 * ms, 100 * ms + 2 * frame), 100 * ms + 2 * frame);
  EXPECT_EQ(clock.when(10 * ms, 100 * ms + 3 * frame), 100 * ms + 3 * frame);
  EXPECT_EQ(clock.jumps(), 2u);
}

}  // namespace
}  // namespace vdisp
