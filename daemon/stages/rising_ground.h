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
/// rises more by one step than max_height ends this, up to where floor is seen again, so the top of a step is none; and it is only told as
/// far off as a step of max_height would be seen as one.
class RisingGround {
 public:
  explicit RisingGround(const Config& config) : config_(config) {}
  void prepare(const ImageSpec& disparity);
  /// What is an obstacle by its height, and such ground, becomes floor. `tables`: of the frame. `surfaces`: height16, surface and obstacles
  /// of the disparity image, as the stage has them.
  void mark(const Image& disparity, const FloorModel& model, const kernels::HeightTables& tables,
            std::span<Image* const> surfaces) noexcept;

 private:
  /// The last ground in a column of samples: m along the ground, m over the plane of the floor, and its row of samples.
  struct Ground {
    float ahead, up;
    int row;  // -1: nothing leads on
  };
  /// Of a frame. A point at a disparity with the table's `inverse` lies z = inverse * depth m away.
  struct Scale {
    int first;                                         // the table's first disparity
    float depth, noise;                                // noise: m that distances are vague by, at 1 m
    float height, sin_pitch, cos_pitch, across, down;  // of the view: m, and what a px adds to the slope of its ray
    float steepest, recedes, farthest;                 // recedes: m by which level ground does from row to row of samples, at 1 m
  };
  /// What is seen in a row of samples; whether any obstacle of it is ground.
  bool climb(const Image& disparity, std::span<const Image* const> surfaces, const kernels::HeightTables& tables, const Scale& scale,
             int row) noexcept;
  /// Whether an obstacle's sample that lies `on` m behind the ground and `up` m over it, and is vague by so much, is ground too.
  bool leads_on(const Ground& ground, const Scale& scale, float on, float up, float vague, int rows) const noexcept;
  bool among_ground(int row, int column) const noexcept;
  void paint(const Image& disparity, std::span<Image* const> surfaces, int row, int column) const noexcept;
  int u(int column) const { return column * across_ + across_ / 2; }
  int v(const Image& image, int row) const { return image.spec.height - 1 - down_ / 2 - row * down_; }

  const Config& config_;
  std::vector<uint8_t> shows_;  // samples by row, from below, and column: Surface, and `ground`
  std::vector<Ground> ground_;  // by column
  int columns_ = 0, rows_ = 0;
  int across_ = 4, down_ = 4;  // px from sample to sample
};

}  // namespace vdisp
