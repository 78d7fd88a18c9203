// bands_test.cpp: every row once, whatever the number of threads; nothing allocated, nobody awake for nothing.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/bands.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <ctime>
#include <iostream>
#include <set>
#include <string>

#include "daemon/core/clock.h"
#include "tests/support/count_allocations.h"

namespace vdisp {
namespace {

struct BandsTest : testing::TestWithParam<int> {
  Bands bands{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Threads, BandsTest, testing::Values(1, 2, 3, 4, 16), [](const auto& test) { return std::to_string(test.param); });

struct Band {
  int first, last, band;
};
/// The bands of one run, by number.
std::vector<Band> cut(Bands& bands, int rows, int least) {
  std::array<Band, 16> made{};
  std::atomic<int> calls = 0;
  bands.run(rows, least, [&](int first, int last, int band) {
    made.at(static_cast<size_t>(band)) = {first, last, band};
    ++calls;
  });
  EXPECT_EQ(calls, bands.count(rows, least));
  return {made.begin(), made.begin() + calls};
}

TEST_P(BandsTest, each_row_belongs_to_one_band) {
  for (int rows : {1, 2, 3, 7, 15, 16, 17, 100, 479, 480, 8192}) {
    int next = 0, least = rows, most = 0;
    const std::vector<Band> made = cut(bands, rows, 1);
    for (const Band& band : made) {
      EXPECT_EQ(band.first, next);
      next = band.last;
      least = std::min(least, band.last - band.first);
      most = std::max(most, band.last - band.first);
    }
    EXPECT_EQ(next, rows);
    EXPECT_EQ(static_cast<int>(made.size()), std::min(rows, GetParam()));
    EXPECT_LE(most - least, 1) << rows << " rows are not cut evenly";
  }
}

TEST_P(BandsTest, a_band_has_the_least_height_asked_for) {
  for (int rows : {1, 31, 32, 63, 64, 100, 480}) {
    for (const Band& band : cut(bands, rows, 32)) EXPECT_GE(band.last - band.first, std::min(rows, 32)) << rows;
  }
  EXPECT_EQ(bands.count(480, 1000), 1);
  EXPECT_EQ(bands.count(480, 0), GetParam());
}

TEST_P(BandsTest, nothing_to_do_calls_nobody) {
  const auto never = [](int, auto...) { FAIL(); };
  bands.run(0, 1, never);
  bands.run(-1, 1, never);
  bands.each(0, never);
  EXPECT_EQ(bands.count(0), 0);
}

TEST_P(BandsTest, each_task_is_done_once_also_when_there_are_many_more_than_threads) {
  std::vector<std::atomic<int>> done(1000);
  bands.each(1000, [&](int task, int) { ++done[static_cast<size_t>(task)]; });
  for (const auto& times : done) EXPECT_EQ(times, 1);
}

TEST_P(BandsTest, work_space_by_seat_or_band_is_nobody_elses) {
  // Plain memory: a second user at a time is a race that the thread sanitizer sees, and a wrong sum.
  std::array<int, 16> by_seat{}, by_band{};
  for (int i = 0; i < 200; ++i) {
    bands.each(50, [&](int, int seat) { ++by_seat.at(static_cast<size_t>(seat)); });
    bands.run(480, 1, [&](int first, int last, int band) { by_band.at(static_cast<size_t>(band)) += last - first; });
  }
  int seats = 0, rows = 0;
  for (int n : by_seat) seats += n;
  for (int n : by_band) rows += n;
  EXPECT_EQ(seats, 200 * 50);
  EXPECT_EQ(rows, 200 * 480);
}

TEST_P(BandsTest, what_a_body_wrote_is_there_after_each_of_many_small_runs) {
  std::vector<uint32_t> rows(24);  // plain: read by the caller after each run
  for (uint32_t i = 1; i <= 100'000; ++i) {
    bands.run(24, 1, [&](int first, int last, int) {
      for (int row = first; row < last; ++row) rows[static_cast<size_t>(row)] += i;
    });
    if (rows[0] != rows[23]) FAIL() << "run " << i;
  }
  for (uint32_t sum : rows) EXPECT_EQ(sum, static_cast<uint32_t>(100'000ull * 100'001 / 2));
}

TEST_P(BandsTest, from_within_a_body_bodies_run_inline) {
  std::array<int, 64> rows{};
  bands.run(64, 1, [&](int first, int last, int) {
    const std::thread::id self = std::this_thread::get_id();
    bands.run(last - first, 1, [&](int from, int to, int) {
      EXPECT_EQ(std::this_thread::get_id(), self);
      for (int row = first + from; row < first + to; ++row) ++rows[static_cast<size_t>(row)];
    });
  });
  for (int times : rows) EXPECT_EQ(times, 1);
}

TEST_P(BandsTest, two_threads_may_call_at_once) {
  std::atomic<int> sum = 0;
  const auto calls = [&] {
    for (int i = 0; i < 2000; ++i) bands.run(16, 1, [&](int first, int last, int) { sum += last - first; });
  };
  std::thread other(calls);
  calls();
  other.join();
  EXPECT_EQ(sum, 2 * 2000 * 16);
}

TEST_P(BandsTest, no_run_takes_from_the_heap) {
  std::atomic<uint64_t> most = 0;
  std::array<uint64_t, 16> at_first{};
  uint64_t large_capture[8] = {1, 2, 3, 4, 5, 6, 7, 8};  // more than a std::function would hold without the heap
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 1000; ++i) {
    bands.each(64, [&, large_capture](int, int seat) {
      uint64_t& first = at_first[static_cast<size_t>(seat)];
      if (first == 0) first = allocations_of_this_thread() + large_capture[0];
      most = std::max<uint64_t>(most, allocations_of_this_thread() + large_capture[0] - first);
    });
  }
  EXPECT_EQ(allocations_of_this_thread(), before);
  EXPECT_EQ(most, 0u) << "in one of the threads";
}

TEST_P(BandsTest, threads_have_names_and_leave_signals_to_main) {
  std::set<std::string> names;
  std::array<std::string, 16> name;
  std::array<bool, 16> blocked{};
  for (int i = 0; i < 1000 && static_cast<int>(names.size()) < GetParam(); ++i) {
    bands.each(GetParam(), [&](int, int seat) {
      char text[16];
      pthread_getname_np(pthread_self(), text, sizeof text);
      name[static_cast<size_t>(seat)] = text;
      sigset_t mask;
      pthread_sigmask(SIG_BLOCK, nullptr, &mask);
      blocked[static_cast<size_t>(seat)] = sigismember(&mask, SIGTERM) && sigismember(&mask, SIGINT) && !sigismember(&mask, SIGSEGV);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // so that every thread gets one
    });
    names = {name.begin(), name.end()};
    names.erase("");
  }
  EXPECT_FALSE(blocked[0]) << "the caller's own mask was changed";
  for (int seat = 1; seat < GetParam(); ++seat) {
    EXPECT_EQ(name[static_cast<size_t>(seat)], "vdisp-band-" + std::to_string(seat));
    EXPECT_TRUE(blocked[static_cast<size_t>(seat)]);
  }
}

int64_t cpu_ns() {
  timespec used;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return used.tv_sec * 1'000'000'000LL + used.tv_nsec;
}

TEST_P(BandsTest, idle_threads_sleep) {
  const int64_t used = cpu_ns(), start = monotonic_ns();
  for (int frame = 0; frame < 8; ++frame) {
    for (int stage = 0; stage < 10; ++stage) bands.run(480, 1, [](int, int, int) {});
    std::this_thread::sleep_for(std::chrono::milliseconds(66));
  }
  const double share = static_cast<double>(cpu_ns() - used) / static_cast<double>(monotonic_ns() - start);
  std::cout << "CPU at 15 Hz, 10 empty runs a frame, " << GetParam() << " threads: " << 100 * share << " %\n";
  EXPECT_LT(share, 0.1) << "somebody is awake for nothing";
}

TEST_P(BandsTest, an_empty_run_costs_little) {
  // Measured and printed, not judged: the time of a test on a busy machine says nothing.
  const auto empty = [](int, int, int) {};
  constexpr int runs = 20'000, pauses = 200;
  int64_t start = monotonic_ns();
  for (int i = 0; i < runs; ++i) bands.run(480, 1, empty);
  const int64_t awake = (monotonic_ns() - start) / runs;
  std::array<int64_t, pauses> asleep;
  for (int64_t& time : asleep) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    start = monotonic_ns();
    bands.run(480, 1, empty);
    time = monotonic_ns() - start;
  }
  std::sort(asleep.begin(), asleep.end());
  std::cout << "empty run, " << GetParam() << " threads: " << awake << " ns one after the other, " << asleep[pauses / 2]
            << " ns (median) after a pause of 1 ms\n";
}

}  // namespace
}  // namespace vdisp
