// scene_view.cpp: what a pose sees of the scene, in numbers: planes, objects, edges of the ground, and what is at a place.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/sim/scene.h"

namespace vdisp::sim {
namespace {

constexpr double listed_range = 12;  // m ahead, of the truth's list
constexpr double found = 1e-5;       // m, from the ground searched for

double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace

GroundPlane Scene::plane(const CameraPose& pose, double rise) const {
  if (ground_.meshed()) {
    const Point seen = turned_back(pose.axes, turned(pose.level, {0, 1, 0}));
    return {std::asin(seen.z), std::atan2(seen.x, seen.y), parameters_.cameraHeight};
  }
  const double size = std::hypot(1.0, rise);
  const Point down{0, 1 / size, rise / size};
  const Point seen = turned_back(pose.axes, down);
  return {std::asin(seen.z), std::atan2(seen.x, seen.y), rise * Ground::slope_start / size - dot(down, pose.position)};
}

void Scene::describe_ground(const CameraPose& pose, TruthScene& scene) const {
  // REP-103: x ahead and y to the left of where the rover was at the start.
  scene.x_m = pose.foot.z;
  scene.y_m = -pose.foot.x;
  scene.yaw_rad = std::remainder(pose.way, 2 * M_PI);
  // From the world to frame h seen from above; all shapes but the yard's lie before the rover.
  const auto level = [&](double x, double z) {
    return turned_back(pose.level, {x - pose.position.x, ground(x, z) - pose.position.y, z - pose.position.z});
  };
  const auto ahead = [&](double z) { return std::max(0.0, level(pose.foot.x - (z - pose.foot.z) * std::tan(pose.heading), z).z); };
  if (std::abs(std::remainder(pose.heading, 2 * M_PI)) < 1.2) {
    scene.foot_m = ground_.rise() != 0 ? ahead(ground_.foot()) : 0;
    scene.crest_m = ground_.crest() > 0 && ground_.rise() != 0 ? ahead(ground_.crest()) : 0;
  }
  if (ground_.meshed()) scene.slope_rad = scene.foot_m > 0 ? std::atan(ground_.rise()) : 0;
  const Hollow& h = ground_.hollow();
  if (h.depth <= 0) return;
  constexpr double listed = 20;  // m aside
  const double c = std::cos(h.turn), s = std::sin(h.turn);
  const auto corner = [&](double aside) { return level(c * aside - s * h.near, c * h.near + s * aside); };
  const Point left = corner(std::max(h.left, -listed)), right = corner(std::min(h.right, listed));
  scene.drop = {static_cast<float>(h.depth), h.far < Hollow::beyond ? static_cast<float>(h.far - h.near) : 0.0f,
                static_cast<float>(left.x),  static_cast<float>(left.z),
                static_cast<float>(right.x), static_cast<float>(right.z)};
}

Place Scene::place(const CameraPose& pose, double x, double z) const {
  Place place{};
  // Straight down in frame h to the ground: its slope is less than the search's steps can follow.
  double down = parameters_.cameraHeight;
  Point world{};
  for (int step = 0; step < 12; ++step) {
    world = turned(pose.level, {x, down, z});
    world = {world.x + pose.position.x, world.y + pose.position.y, world.z + pose.position.z};
    const double over = ground(world.x, world.z) - world.y;
    if (std::abs(over) < found) break;
    down += over / pose.level[4];
  }
  place.down = down;
  place.drop = ground_.drop(world.x, world.z);
  for (const SceneObject& o : objects_) {
    const double dx = world.x - o.x, dz = world.z - o.z, reach = o.width + o.depth;
    if (dx * dx + dz * dz > reach * reach) continue;
    const double c = std::cos(o.yaw), s = std::sin(o.yaw);
    const double along = std::abs(c * dx + s * dz) / (o.width / 2), aside = std::abs(c * dz - s * dx) / (o.depth / 2);
    const bool round = o.kind == ObjectKind::rock || o.kind == ObjectKind::post;
    if (round ? std::hypot(along, aside) > 1 : std::max(along, aside) > 1) continue;
    if (o.bottom < overhang_clearance) place.obstacle = std::max(place.obstacle, o.height);
    if (o.bottom >= overhang_clearance) place.overhang = place.overhang > 0 ? std::min(place.overhang, o.bottom) : o.bottom;
  }
  return place;
}

double Scene::ground_below(const CameraPose& pose, double depth) const {
  double below = 0;
  for (int step = 0; step < 24; ++step) {
    const Point world = turned(pose.axes, {0, below, depth});
    const double over = ground(world.x + pose.position.x, world.z + pose.position.z) - world.y - pose.position.y;
    if (std::abs(over) < found) break;
    below += over / pose.axes[4];
  }
  return below;
}

void Scene::describe(const CameraPose& pose, TruthView& view, std::span<uint8_t> numbers) const {
  TruthScene& scene = view.scene;
  view.planes = {plane(pose, 0), plane(pose, ground_.rise())};
  view.plane_count = ground_.meshed() ? 0 : ground_.rise() != 0 ? 2 : 1;
  view.rising = ground_.rise() > 0;
  const Point ahead = turned(pose.level, {0, 0, 1});
  const GroundPlane& below = view.planes[pose.climbs ? 1 : 0];
  const GroundPlane& other = view.planes[pose.climbs ? 0 : 1];
  scene = TruthScene{};
  scene.header = {TruthScene::type, TruthScene::version, static_cast<uint32_t>(sizeof(TruthScene))};
  scene.pitch_rad = below.pitch;
  scene.roll_rad = below.roll;
  scene.height_m = below.height;
  scene.slope_rad = (pose.climbs ? ahead.z < 0 : ahead.z > 0) ? other.pitch - below.pitch : 0;
  describe_ground(pose, scene);

  struct Seen {
    double distance;
    size_t index;
    Point centre;
  };
  std::array<Seen, TruthView::unlisted> seen;
  size_t count = 0;
  std::fill(numbers.begin(), numbers.end(), TruthView::unlisted);
  for (size_t i = 0; i < objects_.size() && count < seen.size(); ++i) {
    const SceneObject& o = objects_[i];
    const Point world{o.x - pose.position.x, ground(o.x, o.z) - pose.position.y, o.z - pose.position.z};
    const Point centre = turned_back(pose.level, world);
    const double turn = o.yaw - pose.heading;
    const double reach = std::abs(std::sin(turn)) * o.width / 2 + std::abs(std::cos(turn)) * o.depth / 2;
    if (centre.z + reach > 0 && centre.z - reach < listed_range) seen[count++] = {centre.z - reach, i, centre};
  }
  if (count > TruthScene::capacity) {
    std::sort(seen.begin(), seen.begin() + static_cast<long>(count), [](const Seen& a, const Seen& b) { return a.distance < b.distance; });
    count = TruthScene::capacity;
    std::sort(seen.begin(), seen.begin() + static_cast<long>(count), [](const Seen& a, const Seen& b) { return a.index < b.index; });
  }
  scene.count = static_cast<uint32_t>(count);
  for (size_t i = 0; i < count; ++i) {
    const SceneObject& o = objects_[seen[i].index];
    numbers[seen[i].index] = static_cast<uint8_t>(i + 1);
    scene.objects[i] = {o.kind,
                        o.textured && parameters_.texture > 0 ? 1u : 0u,
                        static_cast<float>(seen[i].centre.x),
                        static_cast<float>(seen[i].centre.z),
                        static_cast<float>(o.width),
                        static_cast<float>(o.depth),
                        static_cast<float>(o.height),
                        static_cast<float>(std::remainder(o.yaw - pose.heading, 2 * M_PI)),
                        static_cast<float>(parameters_.cameraHeight - seen[i].centre.y),
                        static_cast<float>(o.bottom)};
  }
}

}  // namespace vdisp::sim
