// plane_search.h: part of `floor`: the plane of disparities that the floor most likely is, of those drawn and expected.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <random>

#include "config/config.h"
#include "daemon/geometry/floor_plane.h"
#include "daemon/kernels/aligned.h"
#include "daemon/stages/machine.h"
#include "daemon/stages/plane_fit.h"
#include "ipc/image.h"

namespace vdisp {

/// Random planes through points of the disparity image, judged by what lies on them, less what lies beyond them (nothing is seen through a
/// floor, though over its edge), the ground at the rover's feet above all, and by how well they agree with the mounting and the last floor.
/// Guesses keep to the mounting's tolerances first, and to nothing where no floor is found so; what fits from there on may lead out of
/// them, as a mounting can be wrong. Points are drawn by threes; by twos, with a roll taken for granted; and one by one, with roll and
/// height, which finds a floor of which hardly anything is seen. The best are fitted to their points, with Tukey's weights,
/// until they settle, as what is found shall not depend on chance.
class PlaneSearch {
 public:
  PlaneSearch(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  void prepare(const ImageSpec& disparity);

  struct Found {
    FloorPlane plane;
    kernels::PlaneCount all, feet;  // of all points, and of the lowest ones of each part of the image's width
    double score;
  };
  /// Takes every few pixels of the disparity image that have a disparity above 0. Returns how many.
  size_t collect(const Image& disparity);
  size_t points() const { return all_.n; }
  size_t most_points() const { return all_.u.size(); }
  /// u - cx, v - cy and true disparity of a point.
  std::array<double, 3> point(size_t i) const {
    return {static_cast<double>(all_.u[i]), static_cast<double>(all_.v[i]), static_cast<double>(all_.d[i])};
  }
  /// Where the floor is expected, and the angle off it, rad, at which that counts half.
  struct Expected {
    FloorPlane plane;
    double off;
  };
  /// The same points and seed give the same plane. `last`: the floor of the last frame as it should lie now, or null. `trusted`: [mounting]
  /// has been seen to be right, and what is neither its ground nor a ramp of [Floor] maxSlope is no floor: a wall, or half a wall.
  std::optional<Found> search(const StereoView& view, uint64_t seed, const Expected* last, bool trusted);
  /// Enough lies on it to call it a floor.
  static bool holds(const Found& found);
  /// Where a point has this true disparity of the floor it may be off by so much, px.
  static double reach(double floor_disparity);

 private:
  using Random = std::minstd_rand;
  static constexpr size_t kept = 4;

  std::optional<FloorPlane> draw(int kind, Random& random, const StereoView& view) const;
  std::optional<FloorPlane> through_three(Random& random) const;
  std::optional<FloorPlane> through_two(Random& random, double roll) const;
  std::optional<FloorPlane> through_one(Random& random, const StereoView& view, double roll, double height) const;
  enum class Plane { guess, fit };
  /// How far what is known beforehand supports a plane, 0..1; 0: it cannot be the floor.
  double likely(const FloorPlane& plane, Plane kind, const StereoView& view, const Expected* last) const;
  bool within_mounting(const PlanePose& pose) const;
  bool drivable(const PlanePose& pose) const;
  std::optional<Found> try_planes(const StereoView& view, Random& random, const Expected* last);
  /// What cannot have a score above `least` scores 0, and is not counted to the end.
  Found judge(const FloorPlane& plane, Plane kind, const StereoView& view, const Expected* last, double least = 0) const;
  size_t any(Random& random) const { return random() % all_.n; }

  struct List {
    mutable kernels::Aligned<float> u, v, d;
    size_t n = 0;
    void reserve(size_t most);
    kernels::DisparityPoints points(size_t from = 0) const { return {u.data() + from, v.data() + from, d.data() + from}; }
    void add(const List& other, size_t i);
  };
  PlanePoints part_of(const List& list) const { return {list.points(), list.n, half_width_, half_height_}; }

  Machine& machine_;
  const Config& config_;
  List all_, few_, feet_;                    // points from below; every few of them; the lowest of each part of the image's width
  double half_width_ = 0, half_height_ = 0;  // px
  bool mounted_ = false;                     // guesses: only what agrees with [mounting]
  bool trusted_ = false;                     // guesses and fits: only what is drivable
  std::optional<double> last_roll_;
};

}  // namespace vdisp
