// crowd.cpp: the scene whose floor is hardly seen, and the one with beams across the way.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "daemon/sim/objects.h"
#include "daemon/sim/scene.h"

namespace vdisp::sim {
namespace {

constexpr double floor_reach = 6;  // m: floor farther away than this is not counted
constexpr double least_share = 0.69, most_share = 0.75;

/// True where the ray meets the object nearer than `most`; rays are in the world, `most` in lengths of `ray`.
bool meets(const SceneObject& o, double ground, const Point& from, const Point& ray, double most) {
  const double c = std::cos(o.yaw), s = std::sin(o.yaw), x = from.x - o.x, z = from.z - o.z;
  const bool round = o.kind == ObjectKind::rock;
  // To axes in which the object is the unit ball, cylinder or cube. A rock is a third in the ground, and its dents take a tenth.
  const double full = round ? 0.9 : 1;
  const double half[3] = {full * o.width / 2, full * (round ? 0.75 : 0.5) * o.height, full * o.depth / 2};
  const double p[3] = {(c * x + s * z) / half[0], (ground - from.y - o.height + half[1] / full) / half[1], (c * z - s * x) / half[2]};
  const double d[3] = {(c * ray.x + s * ray.z) / half[0], -ray.y / half[1], (c * ray.z - s * ray.x) / half[2]};
  if (round) {
    const double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], b = p[0] * d[0] + p[1] * d[1] + p[2] * d[2];
    const double root = b * b - a * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1);
    return root >= 0 && (-b - std::sqrt(root)) / a > 0 && (-b - std::sqrt(root)) / a < most;
  }
  double near = 0, far = most;
  const bool pillar = o.kind == ObjectKind::post;
  if (pillar) {
    const double a = d[0] * d[0] + d[2] * d[2], b = p[0] * d[0] + p[2] * d[2], root = b * b - a * (p[0] * p[0] + p[2] * p[2] - 1);
    if (root < 0) return false;
    near = std::max(near, (-b - std::sqrt(root)) / a);
    far = std::min(far, (-b + std::sqrt(root)) / a);
  }
  for (int i = pillar ? 1 : 0; i < (pillar ? 2 : 3); ++i) {
    const double one = (-1 - p[i]) / d[i], other = (1 - p[i]) / d[i];
    near = std::max(near, std::min(one, other));
    far = std::min(far, std::max(one, other));
  }
  return near < far;
}

struct FloorRay {
  Point direction;
  double reach;  ///< lengths of the direction to the floor
  bool covered;
};

/// Rays over the whole view that see the level floor.
std::vector<FloorRay> floor_rays(const CameraPose& pose, const sim_section& parameters) {
  constexpr int columns = 48, rows = 36;
  const double focal = 0.9 * parameters.width;
  std::vector<FloorRay> rays;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Point ray = turned(
          pose.axes, {((i + 0.5) / columns - 0.5) * parameters.width / focal, ((j + 0.5) / rows - 0.5) * parameters.height / focal, 1});
      const double reach = -pose.position.y / ray.y;
      if (ray.y > 0 && pose.position.z + reach * ray.z < floor_reach) rays.push_back({ray, reach, false});
    }
  }
  return rays;
}

}  // namespace

void Scene::build_crowd(Chance& chance) {
  constexpr size_t most_objects = TruthScene::capacity - 2;
  const CameraPose start = pose(0);
  std::vector<FloorRay> rays = floor_rays(start, parameters_);
  const auto all = static_cast<double>(std::max<size_t>(rays.size(), 1));
  size_t covered = 0;
  for (int attempt = 0; attempt < 4000 && static_cast<double>(covered) < least_share * all && objects_.size() < most_objects; ++attempt) {
    SceneObject object = random_object(chance);
    const double place = chance.between(0, 1);  // more of them near, where most of the floor is seen
    object.z = 1 + object.radius() + 3.2 * place * place;
    object.x = chance.between(-0.6, 0.6) * object.z;
    // Nearer than the circles round them would let them stand: side by side, not one in the other.
    if (!fits(object, 0, -0.3 * object.radius())) continue;
    std::vector<FloorRay> next = rays;
    size_t sum = 0;
    for (FloorRay& ray : next) {
      ray.covered |= meets(object, ground(object.x, object.z), start.position, ray.direction, ray.reach);
      sum += ray.covered;
    }
    // What is hidden already, or would close the view, has no place.
    if (sum == covered || static_cast<double>(sum) > most_share * all) continue;
    covered = sum;
    rays = std::move(next);
    objects_.push_back(object);
  }
}

void Scene::build_overhangs(Chance& chance) {
  build_flat(chance);
  const auto hang = [&](double bottom, double least_z) {
    for (int attempt = 0; attempt < 200; ++attempt) {
      // A beam, or the top of a table.
      const double depth = chance.below(2) ? chance.between(0.15, 0.3) : chance.between(0.5, 0.9);
      SceneObject beam = make(ObjectKind::beam, 0, chance.between(least_z, 4.3), chance.between(1, 2.2), depth,
                              bottom + chance.between(0.1, 0.25), chance.between(-0.3, 0.3), chance.between(120, 170));
      beam.bottom = bottom;
      beam.x = chance.between(-0.35, 0.35) * beam.z;
      const bool free =
          ground_.whole(beam.x, beam.z, beam.radius()) && std::none_of(objects_.begin(), objects_.end(), [&](const SceneObject& other) {
            return std::hypot(other.x - beam.x, other.z - beam.z) < 0.7 * (other.radius() + beam.radius());
          });
      if (free) return objects_.push_back(beam);
    }
  };
  hang(chance.between(1.2, 1.6), 2.4);
  if (chance.below(2)) hang(chance.between(0.3, 0.7), 1.8);
}

}  // namespace vdisp::sim
