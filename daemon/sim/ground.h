// ground.h: the shape of the ground: level, sloping, bumpy, or with a step or a ditch across the way.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/frames.h"

namespace vdisp::sim {

struct Mesh {
  std::vector<float> vertices;
  std::vector<unsigned> triangles;
  void vertex(double x, double y, double z) {
    for (double value : {x, y, z}) vertices.push_back(static_cast<float>(value));
  }
  void triangle(unsigned a, unsigned b, unsigned c) { triangles.insert(triangles.end(), {a, b, c}); }
  void quad(unsigned a, unsigned b, unsigned c, unsigned d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
};

/// Where the ground falls away: a rectangle, its near edge turned about the origin by `turn` (positive to the left).
struct Hollow {
  double depth = 0;                       ///< m; 0: there is none
  double turn = 0, near = 0, far = 0;     ///< rad; m ahead of the origin along the turned axis
  double left = 0, right = 0;             ///< m aside, positive to the right
  static constexpr double beyond = 1000;  ///< m; a border that is farther than anybody looks
};

/// Height of the ground over the level below the start, for the world's x (right) and z (ahead). The same everywhere: tracer, truth
/// and obstacles ask here.
class Ground {
 public:
  explicit Ground(const sim_section& parameters);

  /// m over the level at the start; walls of a hollow are `wall` thick.
  double height(double x, double z) const;
  /// m that the ground lies lower than it did before it fell away.
  double drop(double x, double z) const;
  /// True where no edge of a hollow, nor the hollow itself, lies within the radius.
  bool whole(double x, double z, double radius) const;

  /// Whether it must be drawn as triangles. If not it is two planes: level, and one that rises by rise() a metre from
  /// slope_start on.
  bool meshed() const { return meshed_; }
  double rise() const { return rise_; }
  static constexpr double slope_start = 1, wall = 0.002;
  Mesh mesh() const;

  const Hollow& hollow() const { return hollow_; }
  /// m ahead where the slope begins, and where the ground begins to fall more steeply than before (0: nowhere).
  double foot() const { return foot_; }
  double crest() const { return crest_; }

 private:
  double profile(double z) const;
  double bumps(double x, double z) const;

  struct Wave {
    double along_x, along_z, phase;
  };
  double rise_, foot_ = slope_start, crest_ = 0, roughness_;
  bool meshed_, peaks_ = false, drives_;
  double reach_;  ///< m from the origin that bumps are drawn to
  Hollow hollow_;
  std::array<Wave, 12> waves_;
};

}  // namespace vdisp::sim
