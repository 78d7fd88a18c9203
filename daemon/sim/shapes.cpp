// shapes.cpp: boxes, posts, walls and rocks as triangles.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/shapes.h"

#include <algorithm>
#include <cmath>

#include "daemon/sim/chance.h"
#include "daemon/sim/robot.h"

namespace vdisp::sim {
namespace {

constexpr double sunk = 0.3;  // m that shapes go into the ground, so that no slope lifts them off

/// From the object's own axes (along its width, up, along its depth) to the world.
Point placed(const SceneObject& o, double ground, double along, double up, double aside) {
  const double c = std::cos(o.yaw), s = std::sin(o.yaw);
  return {o.x + c * along - s * aside, ground - up, o.z + s * along + c * aside};
}

/// Where the lowest part of a box lies, over the ground.
double lowest(const SceneObject& o) { return o.bottom > 0 ? o.bottom : -sunk; }

void add(Mesh& mesh, const Point& p) { mesh.vertex(p.x, p.y, p.z); }

Mesh box(const SceneObject& o, double ground) {
  Mesh mesh;
  for (unsigned k = 0; k < 8; ++k)
    add(mesh, placed(o, ground, (k & 1 ? 0.5 : -0.5) * o.width, k & 2 ? o.height : lowest(o), (k & 4 ? 0.5 : -0.5) * o.depth));
  mesh.quad(0, 1, 3, 2);
  mesh.quad(4, 6, 7, 5);
  mesh.quad(0, 2, 6, 4);
  mesh.quad(1, 5, 7, 3);
  mesh.quad(2, 3, 7, 6);
  if (o.bottom > 0) mesh.quad(0, 4, 5, 1);
  return mesh;
}

Mesh post(const SceneObject& o, double ground) {
  constexpr unsigned sides = 16;
  Mesh mesh;
  for (unsigned k = 0; k < sides; ++k) {
    const double a = 2 * M_PI * k / sides, x = std::cos(a) * o.width / 2, z = std::sin(a) * o.depth / 2;
    add(mesh, placed(o, ground, x, lowest(o), z));
    add(mesh, placed(o, ground, x, o.height, z));
  }
  add(mesh, placed(o, ground, 0, o.height, 0));
  for (unsigned k = 0; k < sides; ++k) {
    const unsigned next = (k + 1) % sides;
    mesh.quad(2 * k, 2 * next, 2 * next + 1, 2 * k + 1);
    mesh.triangle(2 * k + 1, 2 * next + 1, 2 * sides);
  }
  return mesh;
}

/// A sphere with bumps, scaled so that it fills its width, depth and height.
Mesh rock(const SceneObject& o, double ground, uint32_t seed) {
  constexpr unsigned around = 28, rings = 14;
  Chance chance(seed);
  std::array<std::array<double, 4>, 9> bumps;
  for (auto& bump : bumps) bump = {chance.between(-4, 4), chance.between(-4, 4), chance.between(-4, 4), chance.between(0, 2 * M_PI)};
  std::vector<Point> points;
  Point least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
  for (unsigned ring = 0; ring <= rings; ++ring) {
    for (unsigned k = 0; k < around; ++k) {
      const double polar = M_PI * ring / rings, a = 2 * M_PI * k / around;
      const Point d{std::sin(polar) * std::cos(a), std::cos(polar), std::sin(polar) * std::sin(a)};
      double r = 1;
      for (const auto& bump : bumps) r += 0.055 * std::sin(bump[0] * d.x + bump[1] * d.y + bump[2] * d.z + bump[3]);
      points.push_back({r * d.x, r * d.y, r * d.z});
      const Point& p = points.back();
      least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
      most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
    }
  }
  Mesh mesh;
  for (const Point& p : points) {
    const double along = ((p.x - least.x) / (most.x - least.x) - 0.5) * o.width,
                 aside = ((p.z - least.z) / (most.z - least.z) - 0.5) * o.depth;
    // A third of it is in the ground.
    const double up = ((p.y - least.y) / (most.y - least.y) * 1.5 - 0.5) * o.height;
    add(mesh, placed(o, ground, along, up, aside));
  }
  for (unsigned ring = 0; ring < rings; ++ring) {
    for (unsigned k = 0; k < around; ++k) {
      const unsigned next = (k + 1) % around;
      mesh.quad(ring * around + k, ring * around + next, (ring + 1) * around + next, (ring + 1) * around + k);
    }
  }
  return mesh;
}

}  // namespace

Mesh shape(const SceneObject& o, double ground, uint32_t seed) {
  if (o.kind == ObjectKind::post) return post(o, ground);
  return o.kind == ObjectKind::rock ? rock(o, ground, seed) : box(o, ground);
}

uint32_t bumps(uint32_t scene_seed, size_t index) { return scramble(scene_seed * 977 + static_cast<uint32_t>(index)); }

Footprint covered(const SceneObject& o, uint32_t seed) {
  if (o.kind != ObjectKind::post && o.kind != ObjectKind::rock) return {{o.x, o.z}, o.width, o.depth, o.yaw};
  const Mesh mesh = shape(o, 0, seed);
  const double least = o.height > Robot::climbs ? Robot::climbs : 0;
  std::vector<Spot> points;
  const auto cut = [&](const float* a, const float* b) {
    const double low = -a[1], high = -b[1];
    if (std::max(low, high) < least || std::min(low, high) > Robot::height) return;
    for (const double up : {std::clamp(low, least, Robot::height), std::clamp(high, least, Robot::height)}) {
      const double part = high == low ? 0 : (up - low) / (high - low);
      points.push_back({a[0] + part * (b[0] - a[0]), a[2] + part * (b[2] - a[2])});
    }
  };
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    cut(&mesh.vertices[mesh.triangles[i] * 3], &mesh.vertices[mesh.triangles[i % 3 == 2 ? i - 2 : i + 1] * 3]);
  return Footprint::around({o.x, o.z}, points);
}

std::vector<Corners> boxes_around(const SceneObject& o, double ground) {
  const int parts = 1 + static_cast<int>(o.width / 2.5);
  std::vector<Corners> boxes(static_cast<size_t>(parts));
  for (int part = 0; part < parts; ++part) {
    for (unsigned k = 0; k < 8; ++k) {
      const double along = (static_cast<double>(part + (k & 1 ? 1 : 0)) / parts - 0.5) * o.width;
      boxes[static_cast<size_t>(part)][k] = placed(o, ground, along, k & 2 ? o.height : lowest(o), (k & 4 ? 0.5 : -0.5) * o.depth);
    }
  }
  return boxes;
}

}  // namespace vdisp::sim
