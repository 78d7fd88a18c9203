// scene.cpp: where the camera is in each frame, and what is around it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/scene.h"

#include <cmath>

#include "daemon/sim/ride.h"

namespace vdisp::sim {
namespace {

constexpr double speed = 0.5;     // m/s, of the rover in `drive`
constexpr double gravity = 9.81;  // m/s^2

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

}  // namespace vdisp::sim
