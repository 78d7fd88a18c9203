// scenes.h: for tests: what a camera sees of ground, walls, ditches and kerbs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>

#include "daemon/geometry/frames.h"

namespace vdisp {

constexpr int width = 320, height = 240;
constexpr StereoView view{288, 160, 120, 0.09, 0};
constexpr double high = 0.8, pitch = 0.26;

/// What a ray meets: a distance along the view in m, 0 for nothing.
using Scene = std::function<double(const Point& ray)>;

/// Ground `below` m under the camera that is banked by `roll`.
inline Scene ground(double below, double roll = 0, double down = pitch) {
  return [=](const Point& ray) {
    const double fall = horizontal(ray, down, roll).y;
    return fall > 1e-6 ? below / fall : 0;
  };
}

/// An upright wall `ahead` m away, from the ground to `top` m over it, between two sides in m.
inline Scene with_wall(const Scene& scene, double ahead, double top, double left = -10, double right = 10) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, over = high - h.y * z, across = h.x * z;
    const double behind = scene(ray);
    return over > 0 && over < top && across > left && across < right && (behind == 0 || z < behind) ? z : behind;
  };
}

/// Ground that is level up to `edge` m ahead and then falls so steeply that nothing of it is seen; what stands there is seen over the edge.
inline Scene brow(double edge) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = h.y > 1e-6 ? high / h.y : 0;
    return h.z * z < edge ? z : 0;
  };
}

/// Level ground with a ditch from `near` to `far` m ahead, too deep to see its bottom.
inline Scene ditch(double near, double far) {
  const Scene flat = ground(high);
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = flat(ray), ahead = h.z * z;
    return z > 0 && ahead > near && ahead < far ? far / h.z : z;
  };
}

/// Level ground, `deep` m lower from `edge` m ahead on to the right of `side`; a wall leads along the way between the two.
inline Scene kerb_beside(double edge, double side, double deep) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    double nearest = 0;
    const auto meets = [&](double z, bool there) {
      if (z > 0 && there && (nearest == 0 || z < nearest)) nearest = z;
    };
    const double up = high / h.y, down = (high + deep) / h.y, wall = side / h.x;
    meets(up, h.z * up < edge || h.x * up < side);
    meets(down, h.z * down > edge && h.x * down > side);
    meets(wall, h.z * wall > edge && h.y * wall > high && h.y * wall < high + deep);
    return nearest;
  };
}

/// A wall `ahead` m away that reaches from `bottom` to `top` m over the level of the floor, seen where the ground is not nearer.
inline Scene with_wall_from(const Scene& scene, double ahead, double bottom, double top, double half_width) {
  return [=](const Point& ray) {
    const Point h = horizontal(ray, pitch);
    const double z = ahead / h.z, up = high - h.y * z, behind = scene(ray);
    return up > bottom && up < top && std::abs(h.x * z) < half_width && (behind == 0 || z < behind) ? z : behind;
  };
}

}  // namespace vdisp
