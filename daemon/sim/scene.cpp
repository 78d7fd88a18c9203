// scene.cpp: where the camera is in each frame, and what is around it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "daemon/sim/ride.h"

namespace vdisp::sim {
namespace {

constexpr double listed_range = 12;  // m ahead, of the truth's list
constexpr double found = 1e-5;       // m, from the ground searched for
constexpr double speed = 0.5;        // m/s, of the rover in `drive`
constexpr double gravity = 9.81;     // m/s^2

Axes axes_of(const Point& right, const Point& down, const Point& ahead) {
  return {right.x, down.x, ahead.x, right.y, down.y, ahead.y, right.z, down.z, ahead.z};
}
Point cross(const Point& a, const Point& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point scaled(const Point& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Point unit(const Point& a) { return scaled(a, 1 / std::sqrt(dot(a, a))); }

}  // namespace

double SceneObject::radius() const { return std::hypot(width, depth) / 2; }

Point turned(const Axes& m, const Point& p) {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z, m[3] * p.x + m[4] * p.y + m[5] * p.z, m[6] * p.x + m[7] * p.y + m[8] * p.z};
}
Point turned_back(const Axes& m, const Point& p) {
  return {m[0] * p.x + m[3] * p.y + m[6] * p.z, m[1] * p.x + m[4] * p.y + m[7] * p.z, m[2] * p.x + m[5] * p.y + m[8] * p.z};
}

Scene::Scene(Scene&&) noexcept = default;
Scene::~Scene() = default;

void Scene::enter_world() {
  World world = make_world(parameters_);
  ride_ = std::make_unique<Ride>(parameters_, world);
  objects_ = std::move(world.objects);
  first_moving_ = objects_.size();
  objects_.resize(first_moving_ + People::parts * world.walkers.size());
  ride_->people().draw(std::span(objects_).subspan(first_moving_));
  middle_x_ = world.middle.x;
  middle_z_ = world.middle.z;
  extent_ = world.extent;
  to_light_ = world.to_light;
  ceiling_ = world.ceiling;
  ground_brightness_ = world.ground_brightness;
}

void Scene::step(const Order& order) {
  if (!ride_) return;
  ride_->step(order);
  ride_->people().draw(std::span(objects_).subspan(first_moving_));
}

Scene::Station Scene::along(double length) const {
  const double place = length / path_step_, whole = std::floor(place), part = place - whole;
  const Station& a = path_[static_cast<size_t>(whole) % path_.size()];
  const Station& b = path_[(static_cast<size_t>(whole) + 1) % path_.size()];
  return {a.x + (b.x - a.x) * part, a.z + (b.z - a.z) * part, a.heading + std::remainder(b.heading - a.heading, 2 * M_PI) * part};
}

Scene::Station Scene::station(uint64_t frame) const {
  const double n = static_cast<double>(frame);
  if (ride_) return {ride_->robot().spot.x, ride_->robot().spot.z, ride_->robot().heading};
  if (drives_) {
    const double length = path_step_ * static_cast<double>(path_.size());
    return along(std::fmod(speed * n * static_cast<double>(frame_period_ns(parameters_)) * 1e-9, length));
  }
  // A camera that is never quite still: millimetres and tenths of a degree, the same never twice.
  const double degree = M_PI / 180;
  return {0.006 * std::sin(0.83 * n) + 0.004 * std::sin(0.29 * n), 0.008 * std::sin(0.61 * n) + 0.005 * std::sin(0.173 * n),
          degree * (0.20 * std::sin(0.47 * n) + 0.15 * std::sin(0.117 * n))};
}

double Scene::pitch(uint64_t frame) const {
  if (parameters_.pitching == 0) return parameters_.pitch;
  const double seconds = static_cast<double>(frame) * static_cast<double>(frame_period_ns(parameters_)) * 1e-9;
  return parameters_.pitch + parameters_.pitching * std::sin(2 * M_PI * parameters_.pitchingRate * seconds);
}

/// Straight down for a rover that stands there: across the plane through the ends of its wheels' cross.
Point Scene::footing(const Station& at) const {
  constexpr double wheel = 0.2;  // m from the middle
  const double rise_z = (ground_.height(at.x, at.z + wheel) - ground_.height(at.x, at.z - wheel)) / (2 * wheel),
               rise_x = (ground_.height(at.x + wheel, at.z) - ground_.height(at.x - wheel, at.z)) / (2 * wheel);
  return unit({rise_x, 1, rise_z});
}

CameraPose Scene::pose(uint64_t frame) const {
  const Station at = station(frame);
  CameraPose pose;
  pose.heading = at.heading + parameters_.yaw;
  pose.way = at.heading;
  pose.foot = {at.x, ground(at.x, at.z), at.z};
  pose.climbs = !ground_.meshed() && ground_.rise() != 0 && at.z > Ground::slope_start;
  const double rise = pose.climbs ? ground_.rise() : 0;
  const Point down = ground_.meshed() ? footing(at) : unit({0, 1, rise}), view{-std::sin(pose.heading), 0, std::cos(pose.heading)};
  const double sunk = dot(view, down);
  const Point ahead = unit({view.x - sunk * down.x, view.y - sunk * down.y, view.z - sunk * down.z});
  pose.level = axes_of(cross(down, ahead), down, ahead);
  const double height = parameters_.cameraHeight;
  pose.position = {at.x - down.x * height, pose.foot.y - down.y * height, at.z - down.z * height};
  const double pitch_now = pitch(frame);
  const auto axis = [&](const Point& camera_axis) { return turned(pose.level, horizontal(camera_axis, pitch_now, parameters_.roll)); };
  pose.axes = axes_of(axis({1, 0, 0}), axis({0, 1, 0}), axis({0, 0, 1}));
  return pose;
}

Odometry Scene::rover(uint64_t frame) const {
  const Station at = station(frame);
  const Point down = turned(this->pose(frame).level, {0, 1, 0}), view{-std::sin(at.heading), 0, std::cos(at.heading)};
  const double sunk = dot(view, down);
  const Point ahead = unit({view.x - sunk * down.x, view.y - sunk * down.y, view.z - sunk * down.z}), right = cross(down, ahead);
  Odometry pose{};
  pose.x = at.z;
  pose.y = -at.x;
  pose.z = -ground(at.x, at.z);
  pose.yaw = std::remainder(at.heading, 2 * M_PI);
  pose.pitch = std::asin(ahead.y);
  pose.roll = std::atan2(right.y, down.y);
  return pose;
}

Imu Scene::imu(uint64_t frame) const {
  const Point down = horizontal(turned_back(pose(frame).axes, {0, 1, 0}), parameters_.pitch, parameters_.roll);
  const Point body = vdisp::rover(down, 0, 0, parameters_.yaw, 0);
  Imu imu{};
  imu.acceleration[0] = -gravity * body.x;
  imu.acceleration[1] = -gravity * body.y;
  imu.acceleration[2] = -gravity * body.z;
  for (double& rate : imu.rate) rate = std::nan("");
  imu.roll = std::atan2(-body.y, -body.z);
  imu.pitch = std::atan2(body.x, std::hypot(body.y, body.z));
  return imu;
}

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
