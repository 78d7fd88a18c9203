// drawn_world.h: boxes on flat ground, some of which move, and the disparities that a camera on a driving rover has of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "daemon/stages/placement.h"
#include "tests/support/picture.h"

namespace vdisp {

/// Upright, its sides along the odometry's axes. m and m/s.
struct DrawnBox {
  double x, y, size_x, size_y, height;
  double speed_x = 0, speed_y = 0;
  double from_s = -1e9, to_s = 1e9;  ///< there only then
};

struct DrawnRover {
  double x = 0, y = 0, yaw = 0;
};

class DrawnWorld {
 public:
  static constexpr int width = 320, height = 240;
  static constexpr double high = 0.8, pitch = 0.26;
  StereoView view{288, 160, 120, 0.09, 0};
  std::vector<DrawnBox> boxes;
  /// Nothing nearer than this, m along the view, is seen at all: rays pass through it.
  double least_depth = 0;
  /// Where ground has texture: m from here to there, ahead of the camera.
  double ground_from = 0, ground_to = 1e9;

  FloorModel floor() const {
    FloorModel model{};
    model.header = {FloorModel::type, FloorModel::version, static_cast<uint32_t>(sizeof(FloorModel))};
    model.state = FloorState::found;
    model.model = FloorKind::plane;
    const FloorLine line = floor_line(view, high, pitch);
    model.a = line.slope / 16;
    model.b = line.row0;
    model.pitch_rad = pitch;
    model.height_m = high;
    model.confidence = 1;
    return model;
  }

  /// disparity16 at `seconds`, of a search over `disparities` px.
  void draw(const DrawnRover& rover, double seconds, int disparities, Picture& picture) const {
    const Placement placement(mounting_section{}, rover.x, rover.y, rover.yaw);
    picture.fill<int16_t>([&](int v, int u) {
      const double z = depth(placement, seconds, {(u - view.cx) / view.f, (v - view.cy) / view.f, 1});
      const long d = z > 0 ? std::lround(16 * view.disparity(z)) : 0;
      return d > 0 && d < 16 * (disparities - 1) ? static_cast<int16_t>(d) : rejected(Rejected::low_texture);
    });
  }

 private:
  /// Along the view to what the ray (depth 1) meets first; 0: nothing that can be seen.
  double depth(const Placement& placement, double seconds, const Point& ray) const {
    const Point h = horizontal(ray, pitch);
    const OnGround from = placement.outside(0, 0), to = placement.outside(h.x, h.z);
    double nearest = h.y > 1e-6 ? high / h.y : 0;
    if (nearest * h.z < ground_from || nearest * h.z > ground_to) nearest = 0;
    for (const DrawnBox& box : boxes) {
      if (seconds < box.from_s || seconds >= box.to_s) continue;
      const double z = meet(box, seconds, from, {to.x - from.x, to.y - from.y}, h.y);
      if (z > least_depth && (nearest == 0 || z < nearest)) nearest = z;
    }
    return nearest;
  }

  static double meet(const DrawnBox& box, double seconds, const OnGround& from, const OnGround& way, double down) {
    const double x = box.x + box.speed_x * seconds, y = box.y + box.speed_y * seconds;
    double enter = 0, leave = 1e9;
    const auto slab = [&](double start, double step, double low, double top) {
      if (std::abs(step) < 1e-12) {
        if (start < low || start > top) leave = -1;
        return;
      }
      const double a = (low - start) / step, b = (top - start) / step;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    };
    slab(from.x, way.x, x - box.size_x / 2, x + box.size_x / 2);
    slab(from.y, way.y, y - box.size_y / 2, y + box.size_y / 2);
    if (leave <= enter || enter <= 0) return 0;
    if (high - down * enter > box.height) enter = down > 0 ? (high - box.height) / down : 1e9;  // over the front, onto the top
    return enter < leave && high - down * enter >= 0 ? enter : 0;
  }
};

}  // namespace vdisp
