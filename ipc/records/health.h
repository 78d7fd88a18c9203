// health.h: what was lost since the daemon's start, and how long a frame takes from its exposure to the map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "cameras.h"
#include "record.h"

namespace vdisp {

/// Durations counted in fixed buckets, 32 to each doubling: the width of a bucket is at most 1/32 of what lies in it. Adding one costs no
/// allocation and no search. Ticks are 1024 ns; what is longer than 17 s is counted in the last bucket.
struct LatencyHistogram {
  static constexpr uint32_t parts = 32, doublings = 19, buckets = parts * (doublings + 1);
  uint64_t count;
  int64_t sum_ns, max_ns;
  uint64_t counts[buckets];

  static constexpr uint32_t bucket_of(int64_t ns) {
    const uint64_t ticks = ns > 0 ? static_cast<uint64_t>(ns) >> 10 : 0;
    const int shift = std::max(static_cast<int>(std::bit_width(ticks)) - 6, 0);
    const uint64_t bucket = static_cast<uint64_t>(shift) * parts + (ticks >> shift);
    return static_cast<uint32_t>(std::min<uint64_t>(bucket, buckets - 1));
  }
  /// The shortest duration of the bucket; of buckets: the end of the last one.
  static constexpr int64_t begin_ns(uint32_t bucket) {
    const uint32_t shift = bucket < 2 * parts ? 0 : bucket / parts - 1;
    return static_cast<int64_t>(bucket - shift * parts) << (shift + 10);
  }

  void add(int64_t ns) {
    ++count;
    sum_ns += ns;
    max_ns = std::max(max_ns, ns);
    ++counts[bucket_of(ns)];
  }
  /// The duration that a share of 0 to 1 of all does not exceed: the end of its bucket, too long by 1/32 at most. 0 where nothing was
  /// counted.
  int64_t percentile_ns(double share) const {
    const auto wanted = static_cast<uint64_t>(std::ceil(share * static_cast<double>(count)));
    uint64_t seen = 0;
    for (uint32_t i = 0; i < buckets; ++i) {
      seen += counts[i];
      if (seen >= wanted && seen > 0) return i + 1 == buckets ? max_ns : std::min(begin_ns(i + 1), max_ns);
    }
    return max_ns;
  }
  /// What was counted since `earlier`, a look at the same counts. Its longest duration is known to its bucket only.
  LatencyHistogram since(const LatencyHistogram& earlier) const {
    LatencyHistogram difference{};
    difference.count = count - earlier.count;
    difference.sum_ns = sum_ns - earlier.sum_ns;
    for (uint32_t i = 0; i < buckets; ++i) {
      difference.counts[i] = counts[i] - earlier.counts[i];
      if (difference.counts[i] > 0) difference.max_ns = i + 1 == buckets ? max_ns : std::min(begin_ns(i + 1), max_ns);
    }
    return difference;
  }
};

/// Published once a second as topic `health`. All counts are since the start of the daemon.
struct Health {
  static constexpr RecordType type = RecordType::health;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t reasons = 64;  ///< room for more than there are
  RecordHeader header;
  int64_t since_ns;               ///< start of the daemon, CLOCK_MONOTONIC
  uint64_t frames;                ///< steps of the tree, blind ones counted
  uint64_t no_pair;               ///< of those: the source had no good pair
  uint64_t blind_frames;          ///< the map was blind, for lack of a pair too
  uint64_t blind[reasons];        ///< of those: by Reason
  uint64_t loans;                 ///< images made, of all topics
  uint64_t drops;                 ///< of those: no loan could be had, as readers held every block, and nobody saw the image
  uint64_t map_drops;             ///< of those: maps
  int64_t deadline_ns;            ///< that counts now; 0: none
  uint32_t deadline_of_exposure;  ///< 1: deadline_ns counts from the exposure ([main] deadline); 0: from when the pair was there
  uint32_t cameras;               ///< 1: the counts of `camera` are of cameras; 0: there are none
  uint64_t deadline_misses;       ///< maps that came later
  CameraStatus camera;            ///< lost frames, pairs given up; no header
  uint64_t inputs_accepted[4], inputs_refused[4];                      ///< odometry, IMU, drive orders, events
  uint64_t connections_refused, connections_closed, requests_refused;  ///< control socket: full; rubbish or deaf; too many at a time
  uint64_t config_generation, reloads, reloads_refused;                ///< changes; vdisp.cfg read again, and not taken for a fault
  uint64_t log_lines_lost;                                             ///< given up while stderr took none
  LatencyHistogram latency;  ///< from the middle of the exposure (synthetic: from when the pair was there) to the map, valid ones
};

static_assert(sizeof(LatencyHistogram) == 24 + 8 * 640 && sizeof(Health) % 8 == 0);

/// The four of Health::inputs_accepted, for files and for people.
inline constexpr const char* input_names[4] = {"odometry", "imu", "drive", "event"};

}  // namespace vdisp
