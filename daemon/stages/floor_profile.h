// floor_profile.h: part of `floor`: how high the local floor lies over its plane, along the way ahead.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/stages/plane_search.h"
#include "ipc/records.h"

namespace vdisp {

/// The cheapest way through a grid of distances and heights, by dynamic programming: points that lie on it pay, points seen below it cost
/// (obstacles stand on the floor, nothing is seen through it), it neither rises nor falls more than `maxSlope` against the plane, and it
/// falls only where it is seen to, by a tenth of all the ground seen so far off. So ramps, crests and bent ground are floor, and a kerb, a
/// wall or a hole is not. It never lies on what stands upright: a wall that leads along the way from the floor down to lower ground shows
/// each height between them.
class FloorProfile {
 public:
  explicit FloorProfile(const Config& config) : config_(config) {}
  void prepare(size_t most_points);
  /// Fills the profile of a model whose plane is known, in metres.
  void measure(const PlaneSearch& points, const Image& disparity, FloorModel& model) noexcept;
  /// By how much the ground that was measured rises to the right against its plane, m per m.
  double bank(const FloorModel& model) const noexcept;

 private:
  static constexpr int bins = static_cast<int>(FloorModel::profile_capacity), levels = 161, middle = levels / 2, reach = 3;
  struct Scale {
    double start, step, level;  // m
    int count;                  // bins in use
  };
  void count(const PlaneSearch& points, const Image& disparity, const FloorModel& model, const Scale& scale) noexcept;
  void find_way(const FloorModel& model, const StereoView& view, const Scale& scale) noexcept;
  void write(const Scale& scale, FloorModel& model) const noexcept;
  static size_t cell(int bin, int level) { return static_cast<size_t>(bin * levels + level); }

  const Config& config_;
  /// One that does not stand upright: m to the right, m over the plane.
  struct GroundPoint {
    int bin;
    float right, height;
  };
  std::vector<GroundPoint> ground_;
  std::vector<float> seen_;               // points by bin and level, without what stands upright
  std::vector<float> cost_;               // of the cheapest way to here
  std::vector<int8_t> came_from_;         // level of the bin before, less this one
  int way_[bins] = {}, band_[bins] = {};  // level, and how far from it points lie on it
};

}  // namespace vdisp
