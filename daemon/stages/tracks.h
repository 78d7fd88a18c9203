// tracks.h: stage `tracks`: obstacles followed from frame to frame, with position, size, age and velocity.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "daemon/stages/blobs.h"

namespace vdisp {

/// occupancy (for its time), reason, standing, height, FloorModel and Memory of one frame to the record Tracks. In the odometry frame where
/// Memory has a pose, else against the rover.
///
/// Each track is a Kalman filter of constant velocity, its axes alike; the nearest blob within its uncertainty continues it, oldest tracks
/// first. What is not seen goes on for a second at its last speed. Told from the third sight on.
class ObstacleTracks final : public ImageProcessor {
 public:
  explicit ObstacleTracks(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override;

 private:
  struct Followed {
    uint32_t id;
    double x, y, speed_x, speed_y;
    double place_variance, common, speed_variance;  // of each axis
    Blob last;
    double greatest, smallest;  // m, of its size, lately
    int sights;
    int64_t first_ns, seen_ns;
    bool seen;
  };
  void predict(double seconds) noexcept;
  void associate(std::span<const Blob> blobs, int64_t now_ns) noexcept;
  static bool partly_seen(Followed& track, const Blob& blob) noexcept;
  void update(Followed& track, const Blob& blob, int64_t now_ns) noexcept;
  void begin(const Blob& blob, int64_t now_ns) noexcept;
  void tell(Tracks& tracks, int64_t now_ns) const noexcept;

  const Config& config_;
  Blobs blobs_;
  std::vector<Followed> followed_;  // oldest first; its room is taken once
  uint32_t next_id_ = 1, forgotten_ = 0, frame_ = 0;
  int64_t last_ns_ = 0;
};

}  // namespace vdisp
