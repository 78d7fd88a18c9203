// odometry_check.h: stage `memory`: where the rover was when the frame was taken, and whether that is good enough to remember by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/processor.h"
#include "ipc/records.h"

namespace vdisp {

/// An image of the frame (for its time), in/odometry, which may be blind, and the Tracks of the last frame, to the record Memory. Frames of
/// a live camera and odometry have one clock; odometry that comes with the frames is exact; a simulated or recorded frame is taken now.
///
/// Memory pauses without odometry (none, or older than maxLag) and goes on after it; it is forgotten after a second's pause, where odometry
/// jumps, begins anew, runs backwards in time, or is contradicted: where three obstacles or more move as one rigid body for half a second
/// it is the rover that moves otherwise than the odometry says.
class OdometryCheck final : public ImageProcessor {
 public:
  explicit OdometryCheck(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override;

 private:
  struct Sample {
    int64_t timestamp_ns = 0;
    double x = 0, y = 0, yaw = 0, speed = 0, turn_rate = 0;
  };
  MemoryCause judge(const Image& frame, const Image& odometry, Memory& memory) noexcept;
  void keep(const Odometry& odometry) noexcept;
  Sample carried(int64_t to_ns) const noexcept;
  bool jumped(const Sample& from, const Sample& to) const noexcept;
  bool contradicted(const Image& tracks, int64_t now_ns) noexcept;
  void forget(MemoryCause why, int64_t now_ns) noexcept;

  const Config& config_;
  Sample before_, newest_;  // odometry, at the odometry's own times; timestamp 0 of both: none yet
  int samples_ = 0;
  Sample used_;  // the pose of the last frame that had one, at its time on the odometry's clock
  bool has_used_ = false;
  uint32_t frame_ = 0;
  uint32_t forgotten_ = 0;
  MemoryCause why_ = MemoryCause::none;
  int64_t last_ns_ = 0, since_ns_ = 0;
  bool has_last_ = false, contradicts_ = false;
  int64_t as_one_since_ns_ = -1, as_one_ns_ = -1;  // since when, and when last, all moved as one; -1: they do not, never
};

}  // namespace vdisp
