// rising_ground.h: part of `surface`: ground beside the way that rises no steeper than the rover climbs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/kernels/height.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// The local floor is the same from left to right: what lies higher beside it, a lawn behind a kerb or a bank, is an obstacle by its height
/// where it is more than max_height over the floor. If floor leads up to it, row by row and no steeper than `maxSlope`, it is floor. What
/// is off the line from ground to ground ends this, up to where floor is seen again, so the top of a step is none; and it is only told as
/// far off as a step of max_height would be seen as one. Up to six samples, 24 rows of 480, may lack a disparity or vary by its noise.
class RisingGround {
 public:
  explicit RisingGround(const Config& config) : config_(config) {}
  void prepare(const ImageSpec& disparity);
  /// What is an obstacle by its height, and such ground, becomes floor. `table`: of the frame. `surfaces`: height16, surface and obstacles
  /// of the disparity image, as the stage has them.
  void mark(const Image& disparity, const FloorModel& model, const kernels::HeightTable& table, std::span<Image* const> surfaces) noexcept;

 private:
  /// What a sample shows. `higher`: an obstacle by its height over the local floor; `ground`: what of that is ground.
  enum class Shows : uint8_t { nothing, other, floor, higher, ground };
  /// The last ground in a column of samples.
  struct Ground {
    float ahead = 0, up = 0;  // m along the ground, and over the plane of the floor
    int disparity = 0;        // 1/16 px
    int row = -1;             // of samples; -1: nothing leads on
    bool recedes = false;     // from the ground before it: it is not the foot of something
  };
  struct Sample {
    float ahead, up, depth, vague;  // m; vague: by how much distances may be wrong
    struct {
      float ahead, up;
    } nearest;  // the same where its disparity is greater by the noise
    int disparity;
  };
  /// Of a frame. A point at the disparity d lies table[d - first].inverse * depth m away.
  struct Scale {
    kernels::HeightTable table;
    int first;
    float depth, noise;                                // noise: m that distances are vague by, at 1 m
    float height, sin_pitch, cos_pitch, across, down;  // of the view: m, and what a px adds to the slope of its ray
    float steepest, recedes, farthest;                 // recedes: m by which level ground does from row to row of samples, at 1 m
  };
  void gather(const Image& disparity, std::span<const Image* const> surfaces, int row) noexcept;
  /// Up a column; whether any of it is ground that was an obstacle.
  bool climb(const Image& disparity, const Scale& scale, int column) noexcept;
  Sample look(const Image& disparity, const Scale& scale, int row, int column) const noexcept;
  /// How far behind `from` ground may be seen so many rows of samples higher, m.
  float reach(const Scale& scale, const Ground& from, int rows_on) const noexcept;
  bool stands_between(const Image& disparity, const Ground& from, const Ground& to, int column) const noexcept;
  bool join(const Ground& from, const Ground& to, int column) noexcept;
  bool among_ground(int row, int column) const noexcept;
  void paint(const Image& disparity, std::span<Image* const> surfaces, int row, int column) const noexcept;
  Shows shows(int row, int column) const { return shows_[static_cast<size_t>(row * columns_ + column)]; }
  Shows& shows(int row, int column) { return shows_[static_cast<size_t>(row * columns_ + column)]; }
  int column_of(int column) const { return column * across_ + across_ / 2; }  // px
  int row_of(const Image& image, int row) const { return image.spec.height - 1 - down_ / 2 - row * down_; }

  const Config& config_;
  std::vector<Shows> shows_;      // samples by row, from below, and column
  std::vector<int> higher_from_;  // by column: the first row that shows something higher
  int columns_ = 0, rows_ = 0;
  int across_ = 4, down_ = 4;  // px from sample to sample
  int step_mm_ = 0;
};

}  // namespace vdisp
