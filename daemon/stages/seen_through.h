// seen_through.h: whether the rays of a frame passed through the place where an obstacle is remembered.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bitset>

#include "config/config.h"
#include "daemon/stages/local_floor.h"

namespace vdisp {

/// Of one frame. Places are in frame h: m to the right, m ahead, on the local floor.
class SeenThrough {
 public:
  SeenThrough(const Config& config, const Image& disparity, const FloorModel& floor);

  /// What stands there as high as max_height is nearer than can be matched: no ray tells whether it still does.
  bool too_near(double right, double ahead) const noexcept;
  /// What is remembered so near hides what lies behind it, although it cannot be matched itself: whatever is "seen" there is not believed.
  void hide_behind(double right, double ahead) noexcept;
  bool hidden(double right, double ahead) const noexcept;
  /// Of the rays through the cell there, from just over the floor to max_height, a third or more end farther off, and none in it or nearer.
  bool passed(double right, double ahead) const noexcept;

 private:
  static constexpr int bins = 128;  // of the columns of the view
  Point seen_at(double right, double ahead, double above) const noexcept;
  int bin(double column) const noexcept;

  const Config& config_;
  const Image& disparity_;
  StereoView view_;
  LocalFloor floor_;
  double height_, pitch_, roll_, nearest_;  // m, rad, rad; least depth along the view, m
  std::bitset<bins> hidden_;
};

}  // namespace vdisp
