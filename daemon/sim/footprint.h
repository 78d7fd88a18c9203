// footprint.h: what a thing covers of the ground, as a convex outline: distances, overlaps, and what lies in a strip ahead.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <span>

namespace vdisp::sim {

/// A place on the ground, world frame: x right, z ahead.
struct Spot {
  double x = 0, z = 0;
};
inline double distance(const Spot& a, const Spot& b) { return std::hypot(a.x - b.x, a.z - b.z); }
/// The unit vector of a heading, which is positive to the left.
inline Spot towards(double heading) { return {-std::sin(heading), std::cos(heading)}; }

class Footprint {
 public:
  static constexpr int most = 32;
  /// A rectangle across and along a heading.
  Footprint(const Spot& middle, double width, double depth, double heading);
  /// What holds all the points: sides at equal angles, each of which touches one. Half a percent of its radius larger than their hull at
  /// most.
  static Footprint around(const Spot& middle, std::span<const Spot> points);
  static Footprint disc(const Spot& middle, double radius);

  const Spot& middle() const { return middle_; }
  double radius() const { return radius_; }  ///< of the circle round it
  const Spot* begin() const { return corners_.data(); }
  const Spot* end() const { return corners_.data() + count_; }

  bool holds(const Spot& spot) const;
  bool meets(const Footprint& other) const;
  /// m between the borders; 0 where they meet.
  double gap(const Footprint& other) const;
  /// m from the spot to the border; 0 inside.
  double gap(const Spot& spot) const;
  /// m along a unit vector from a spot to the nearest of what lies in a strip `half` m to each side; `far` where nothing does before it.
  double ahead(const Spot& from, const Spot& along, double half, double far) const;

 private:
  Footprint() = default;
  void enclose(const std::array<double, most>& reach);
  bool apart(const Footprint& other) const;

  Spot middle_;
  double radius_ = 0;
  int count_ = 0;
  std::array<Spot, most> corners_;  ///< anticlockwise from above
};

}  // namespace vdisp::sim
