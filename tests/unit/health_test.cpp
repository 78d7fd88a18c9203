// health_test.cpp: percentiles against sorted numbers, late and blind frames by arithmetic, and the file that Prometheus reads.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "daemon/core/ledger.h"
#include "daemon/metrics.h"
#include "ipc/outlet.h"
#include "ipc/png.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

constexpr int64_t ms = 1'000'000;

TEST(LatencyHistogram, every_bucket_begins_where_the_one_before_ends_and_is_narrow) {
  for (uint32_t i = 0; i + 1 < LatencyHistogram::buckets; ++i) {
    const int64_t begin = LatencyHistogram::begin_ns(i), end = LatencyHistogram::begin_ns(i + 1);
    ASSERT_EQ(LatencyHistogram::bucket_of(begin), i);
    ASSERT_EQ(LatencyHistogram::bucket_of(end - 1), i);
    ASSERT_LE(end - begin, std::max<int64_t>(1024, begin / 32)) << i;
  }
  EXPECT_EQ(LatencyHistogram::bucket_of(-5), 0u);
  EXPECT_EQ(LatencyHistogram::bucket_of(INT64_MAX), LatencyHistogram::buckets - 1);
}

TEST(LatencyHistogram, percentiles_are_those_of_the_sorted_numbers_to_a_thirty_second_part) {
  std::mt19937 random(3);
  std::lognormal_distribution<double> usual(std::log(6e6), 0.4);
  for (const size_t count : {1u, 2u, 999u, 1000u, 20000u}) {
    LatencyHistogram histogram{};
    std::vector<int64_t> all;
    for (size_t i = 0; i < count; ++i) all.push_back(static_cast<int64_t>(usual(random)) + (i % 500 == 0 ? 90 * ms : 0));
    for (const int64_t one : all) histogram.add(one);
    std::sort(all.begin(), all.end());
    for (const double share : {0.5, 0.9, 0.99, 0.999, 1.0}) {
      const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(count)));
      const int64_t truth = all[rank - 1], found = histogram.percentile_ns(share);
      EXPECT_GE(found, truth) << count << " " << share;
      EXPECT_LE(found, truth + truth / 32 + 1024) << count << " " << share;
    }
    EXPECT_EQ(histogram.max_ns, all.back());
    EXPECT_EQ(histogram.count, count);
  }
}

TEST(LatencyHistogram, empty_one_has_no_percentile_and_a_difference_holds_only_what_came_since) {
  LatencyHistogram histogram{};
  EXPECT_EQ(histogram.percentile_ns(0.999), 0);
  for (int i = 0; i < 100; ++i) histogram.add(500 * ms);
  const LatencyHistogram before = histogram;
  for (int i = 0; i < 10; ++i) histogram.add(5 * ms);
  const LatencyHistogram since = histogram.since(before);
  EXPECT_EQ(since.count, 10u);
  EXPECT_EQ(since.sum_ns, 50 * ms);
  EXPECT_NEAR(static_cast<double>(since.max_ns), 5e6, 5e6 / 32) << "the half second was before";
  EXPECT_EQ(histogram.max_ns, 500 * ms);
}

struct LedgerTest : testing::Test {
  BufferOutlet outlet{{Pixel::count16, 0, 4, 4}};
  Ledger ledger;
  Health health{};

  /// A map `late_ns` after its pair was there, whose exposure was 20 ms before.
  void frame(int64_t late_ns, bool synthetic = false, Reason blind = Reason::none) {
    Image& image = outlet.loan();
    image.state = ImageState::valid;
    image.reason = Reason::none;
    image.flags = synthetic ? uint32_t{flag_synthetic} : 0u;
    image.timestamp_ns = 980 * ms;
    if (blind != Reason::none) image.set_blind(blind);
    ledger.pair(blind == Reason::no_frame ? 0 : 1000 * ms);
    ledger.result(image, 1000 * ms + late_ns);
    ledger.write(health);
  }
};

TEST_F(LedgerTest, latency_counts_from_the_exposure_and_of_synthetic_pairs_from_when_they_were_there) {
  frame(7 * ms);
  EXPECT_EQ(health.latency.max_ns, 27 * ms);
  EXPECT_EQ(health.latency.sum_ns, 27 * ms);
  frame(7 * ms, true);
  EXPECT_EQ(health.latency.sum_ns, 34 * ms);
  EXPECT_EQ(health.latency.count, 2u);
}

TEST_F(LedgerTest, a_deadline_is_of_the_period_unless_one_is_set_and_then_of_the_exposure) {
  frame(100 * ms);
  EXPECT_EQ(health.deadline_misses, 0u) << "there is none";
  ledger.set_deadline(0, 33 * ms);
  frame(33 * ms);
  EXPECT_EQ(health.deadline_misses, 0u) << "53 ms after the exposure, but before the next pair";
  frame(34 * ms);
  EXPECT_EQ(health.deadline_misses, 1u);
  ledger.set_deadline(50 * ms, 33 * ms);
  frame(30 * ms);
  EXPECT_EQ(health.deadline_misses, 1u);
  frame(31 * ms);
  EXPECT_EQ(health.deadline_misses, 2u);
  frame(31 * ms, true);
  EXPECT_EQ(health.deadline_misses, 2u);
  EXPECT_EQ(health.deadline_ns, 50 * ms);
  EXPECT_EQ(health.deadline_of_exposure, 1u);
}

TEST_F(LedgerTest, blind_maps_are_counted_by_reason_and_have_no_latency) {
  frame(5 * ms, false, Reason::no_floor);
  frame(5 * ms, false, Reason::no_floor);
  frame(5 * ms, false, Reason::no_frame);
  frame(5 * ms);
  EXPECT_EQ(health.blind_frames, 3u);
  EXPECT_EQ(health.blind[static_cast<uint32_t>(Reason::no_floor)], 2u);
  EXPECT_EQ(health.blind[static_cast<uint32_t>(Reason::no_frame)], 1u);
  EXPECT_EQ(health.latency.count, 1u);
}

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

TEST(MetricsText, counts_stand_in_lines_that_prometheus_reads_and_buckets_are_cumulative) {
  Health health{};
  Catalogue catalogue{};
  health.frames = 12;
  health.blind[static_cast<uint32_t>(Reason::no_floor)] = 3;
  for (const int64_t one : {4 * ms, 4 * ms, 12 * ms, 700 * ms}) health.latency.add(one);
  const std::string text = metrics_text(health, catalogue, {}, "a\"b", true);
  for (const char* line : {"vdisp_up{name=\"a\\\"b\"} 1\n", "vdisp_frames_total 12\n", "vdisp_blind_frames_total{reason=\"no_floor\"} 3\n",
                           "vdisp_latency_seconds_bucket{le=\"0.003\"} 0\n", "vdisp_latency_seconds_bucket{le=\"0.005\"} 2\n",
                           "vdisp_latency_seconds_bucket{le=\"0.015\"} 3\n", "vdisp_latency_seconds_bucket{le=\"+Inf\"} 4\n",
                           "vdisp_latency_seconds_sum 0.72\n", "vdisp_latency_quantile_seconds{quantile=\"1\"} 0.7\n"})
    EXPECT_NE(text.find(line), text.npos) << line << text;
  EXPECT_EQ(text.find("vdisp_camera"), text.npos) << "there are none";
  health.cameras = 1;
  health.camera.view[1].incomplete = 9;
  EXPECT_NE(metrics_text(health, catalogue, {}, "a", true).find("vdisp_camera_incomplete_frames_total{camera=\"right\"} 9\n"), text.npos);
}

TEST(MetricsTest, the_file_follows_the_counts_and_says_at_the_end_that_it_is_the_end) {
  const TemporaryFolder folder;
  const auto file = folder / "vdisp.prom";
  Health health{};
  const Catalogue catalogue{};
  {
    Metrics metrics(file, "rover", [](std::string_view line) { ADD_FAILURE() << line; });
    EXPECT_NE(content(file).find("vdisp_up{name=\"rover\"} 1\n"), std::string::npos);
    health.frames = 77;
    metrics.offer(health, catalogue, {});
    for (int i = 0; i < 500 && content(file).find("vdisp_frames_total 77\n") == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_NE(content(file).find("vdisp_frames_total 77\n"), std::string::npos);
  }
  EXPECT_NE(content(file).find("vdisp_up{name=\"rover\"} 0\n"), std::string::npos);
  EXPECT_NE(content(file).find("vdisp_frames_total 77\n"), std::string::npos);
}

TEST(MetricsTest, a_place_that_cannot_be_written_is_refused_at_the_start) {
  EXPECT_THROW(Metrics("/dev/null/vdisp.prom", "rover", [](std::string_view) {}), WriteError);
}

}  // namespace
}  // namespace vdisp
