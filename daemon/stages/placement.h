// placement.h: the camera's horizontal frame h, seen from above, in the odometry frame or the rover's.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "config/config.h"

namespace vdisp {

/// A point on the ground, m: odometry or rover frame (x forward, y left), or frame h (x right, z ahead).
struct OnGround {
  double x, y;
};

/// Where frame h stands: the rover at (x, y, yaw) carries the camera as [mounting] says.
class Placement {
 public:
  Placement(const mounting_section& mounting, double x, double y, double yaw)
      : cos_(std::cos(yaw + mounting.yaw)),
        sin_(std::sin(yaw + mounting.yaw)),
        x_(x + std::cos(yaw) * mounting.x - std::sin(yaw) * mounting.y),
        y_(y + std::sin(yaw) * mounting.x + std::cos(yaw) * mounting.y) {}

  OnGround outside(double right, double ahead) const { return {x_ + cos_ * ahead + sin_ * right, y_ + sin_ * ahead - cos_ * right}; }
  double right(const OnGround& p) const { return sin_ * (p.x - x_) - cos_ * (p.y - y_); }
  double ahead(const OnGround& p) const { return cos_ * (p.x - x_) + sin_ * (p.y - y_); }
  double cosine() const { return cos_; }
  double sine() const { return sin_; }

 private:
  double cos_, sin_, x_, y_;
};

}  // namespace vdisp
