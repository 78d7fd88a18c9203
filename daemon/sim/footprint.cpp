// footprint.cpp: the arithmetic of convex outlines.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/footprint.h"

#include <algorithm>

namespace vdisp::sim {
namespace {

constexpr double step = 2 * M_PI / Footprint::most;  // rad from side to side

double cross(const Spot& a, const Spot& b, const Spot& c) { return (b.x - a.x) * (c.z - a.z) - (b.z - a.z) * (c.x - a.x); }

double to_segment(const Spot& p, const Spot& a, const Spot& b) {
  const double dx = b.x - a.x, dz = b.z - a.z, size = dx * dx + dz * dz;
  const double part = size > 0 ? std::clamp(((p.x - a.x) * dx + (p.z - a.z) * dz) / size, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - part * dx, p.z - a.z - part * dz);
}

}  // namespace

Footprint::Footprint(const Spot& middle, double width, double depth, double heading) : middle_(middle), count_(4) {
  const double c = std::cos(heading), s = std::sin(heading);
  radius_ = std::hypot(width, depth) / 2;
  constexpr double sides[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  for (size_t i = 0; i < 4; ++i) {
    const double a = sides[i][0] * width, b = sides[i][1] * depth;
    corners_[i] = {middle.x + c * a - s * b, middle.z + s * a + c * b};
  }
}

Footprint Footprint::disc(const Spot& middle, double radius) {
  Footprint disc;
  disc.middle_ = middle;
  std::array<double, most> reach;
  reach.fill(radius);
  disc.enclose(reach);
  return disc;
}

Footprint Footprint::around(const Spot& middle, std::span<const Spot> points) {
  Footprint all;
  all.middle_ = middle;
  std::array<double, most> reach;
  reach.fill(-INFINITY);
  for (int i = 0; i < most; ++i) {
    const double angle = step * i, c = std::cos(angle), s = std::sin(angle);
    double& far = reach[static_cast<size_t>(i)];
    for (const Spot& p : points) far = std::max(far, c * (p.x - middle.x) + s * (p.z - middle.z));
  }
  all.enclose(reach);
  return all;
}

/// Between the lines across each direction, as far from the middle as `reach` says: neighbours meet in a corner.
void Footprint::enclose(const std::array<double, most>& reach) {
  // Where both touch the same point there is no side between them, and a side without length has no direction.
  constexpr double same = 1e-6;  // m
  for (int i = 0; i < most; ++i) {
    const double here = reach[static_cast<size_t>(i)], next = reach[static_cast<size_t>((i + 1) % most)], angle = step * i;
    const double aside = (next - here * std::cos(step)) / std::sin(step), c = std::cos(angle), s = std::sin(angle);
    const Spot corner{middle_.x + c * here - s * aside, middle_.z + s * here + c * aside};
    if (count_ > 0 && distance(corner, corners_[static_cast<size_t>(count_) - 1]) < same) continue;
    corners_[static_cast<size_t>(count_++)] = corner;
    radius_ = std::max(radius_, distance(corner, middle_));
  }
  while (count_ > 1 && distance(corners_[static_cast<size_t>(count_) - 1], corners_[0]) < same) --count_;
}

bool Footprint::holds(const Spot& spot) const {
  for (const Spot* a = begin(); a != end(); ++a)
    if (cross(*a, a + 1 == end() ? *begin() : a[1], spot) < 0) return false;
  return true;
}

/// Whether one of its own sides has all of the other beyond it.
bool Footprint::apart(const Footprint& other) const {
  for (const Spot* a = begin(); a != end(); ++a) {
    const Spot& b = a + 1 == end() ? *begin() : a[1];
    if (std::all_of(other.begin(), other.end(), [&](const Spot& p) { return cross(*a, b, p) < 0; })) return true;
  }
  return false;
}

bool Footprint::meets(const Footprint& other) const {
  return distance(middle_, other.middle_) <= radius_ + other.radius_ && !apart(other) && !other.apart(*this);
}

double Footprint::gap(const Spot& spot) const {
  if (holds(spot)) return 0;
  double least = INFINITY;
  for (const Spot* a = begin(); a != end(); ++a) least = std::min(least, to_segment(spot, *a, a + 1 == end() ? *begin() : a[1]));
  return least;
}

double Footprint::gap(const Footprint& other) const {
  if (meets(other)) return 0;
  double least = INFINITY;
  for (const Spot& p : other) least = std::min(least, gap(p));
  for (const Spot& p : *this) least = std::min(least, other.gap(p));
  return least;
}

double Footprint::ahead(const Spot& from, const Spot& along, double half, double far) const {
  const auto reach = [&](const Spot& p) { return (p.x - from.x) * along.x + (p.z - from.z) * along.z; };
  const auto aside = [&](const Spot& p) { return (p.x - from.x) * along.z - (p.z - from.z) * along.x; };
  const double middle = reach(middle_);
  if (std::abs(aside(middle_)) > half + radius_ || middle < -radius_ || middle - radius_ > far) return far;
  double nearest = far, behind = -INFINITY;
  // Each side cut at the strip's borders: the nearest of a cut is one of its ends.
  for (const Spot* a = begin(); a != end(); ++a) {
    const Spot& b = a + 1 == end() ? *begin() : a[1];
    const double s0 = aside(*a), s1 = aside(b), r0 = reach(*a), r1 = reach(b);
    if (std::max(s0, s1) < -half || std::min(s0, s1) > half) continue;
    const auto at = [&](double s) { return s1 == s0 ? r0 : r0 + (r1 - r0) * (s - s0) / (s1 - s0); };
    for (const double r : {at(std::clamp(s0, -half, half)), s1 == s0 ? r1 : at(std::clamp(s1, -half, half))}) {
      if (r >= 0) nearest = std::min(nearest, r);
      if (r < 0) behind = std::max(behind, r);
    }
  }
  // What lies both ahead and behind is beside the spot itself.
  return nearest < far && behind > -INFINITY ? 0 : nearest;
}

}  // namespace vdisp::sim
