// yard.cpp: the scenes: a yard to drive through, random obstacles on flat ground, blank ones, the paper's five objects, a wall.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "daemon/sim/objects.h"
#include "daemon/sim/ride.h"

namespace vdisp::sim {
Scene::Scene(const sim_section& parameters) : parameters_(parameters), ground_(parameters) {
  Chance chance(static_cast<uint64_t>(parameters.seed));
  const std::string& name = parameters.scene;
  drives_ = name == "drive";
  if (drives_) {
    lay_path();
    build_yard(chance);
  } else if (name == "flat") {
    build_flat(chance);
  } else if (name == "obstacles") {
    build_five();
  } else if (name == "crowded") {
    build_crowd(chance);
  } else if (name == "overhangs") {
    build_overhangs(chance);
  } else if (name == "blank") {
    build_blank(chance);
  } else if (is_world(name)) {
    enter_world();
  } else if (name == "wall") {
    objects_.push_back(make(ObjectKind::wall, 0, 2, 30, 0.3, 8, 0, 150));
    objects_.back().textured = false;
  }
}

void Scene::lay_path() {
  // A loop that winds: a circle with three bays, walked to the left, moved so that it begins at the origin going ahead.
  constexpr int fine = 16384, stations = 1024;
  constexpr double radius = 7.2, bay = 1.3, phase = 0.9;
  std::vector<Station> raw(fine + 1);
  std::vector<double> length(fine + 1, 0.0);
  for (int i = 0; i <= fine; ++i) {
    const double t = 2 * M_PI * i / fine, r = radius + bay * std::cos(3 * t + phase), dr = -3 * bay * std::sin(3 * t + phase);
    raw[i] = {r * std::cos(t), r * std::sin(t), std::atan2(-(dr * std::cos(t) - r * std::sin(t)), dr * std::sin(t) + r * std::cos(t))};
    if (i > 0) length[i] = length[i - 1] + std::hypot(raw[i].x - raw[i - 1].x, raw[i].z - raw[i - 1].z);
  }
  const Station start = raw[0];
  const double c = std::cos(start.heading), s = std::sin(start.heading);
  path_step_ = length[fine] / stations;
  path_.reserve(stations);
  for (int i = 0, j = 0; i < stations; ++i) {
    while (length[j + 1] < i * path_step_) ++j;
    const double dx = raw[j].x - start.x, dz = raw[j].z - start.z;
    path_.push_back({c * dx + s * dz, -s * dx + c * dz, std::remainder(raw[j].heading - start.heading, 2 * M_PI)});
  }
  middle_x_ = -(c * start.x + s * start.z);
  middle_z_ = -(-s * start.x + c * start.z);
}

double Scene::clearance(double x, double z) const {
  double least = 1e9;
  for (size_t i = 0; i < path_.size(); i += 2) least = std::min(least, std::hypot(path_[i].x - x, path_[i].z - z));
  return least;
}

bool Scene::fits(const SceneObject& object, double path_gap, double gap) const {
  if (drives_ && clearance(object.x, object.z) < path_gap + object.radius()) return false;
  if (!ground_.whole(object.x, object.z, object.radius() + 0.1)) return false;
  return std::none_of(objects_.begin(), objects_.end(), [&](const SceneObject& other) {
    return other.width < 20 && std::hypot(other.x - object.x, other.z - object.z) < gap + other.radius() + object.radius();
  });
}

void Scene::build_yard(Chance& chance) {
  const double half = 12;
  extent_ = half + 1.5;
  for (int side = 0; side < 4; ++side) {
    const double angle = side * M_PI / 2;
    objects_.push_back(make(ObjectKind::wall, middle_x_ + half * std::sin(angle), middle_z_ + half * std::cos(angle), 2 * half + 0.3, 0.3,
                            1.7, -angle, 140));
  }
  const double length = path_step_ * static_cast<double>(path_.size());
  const auto place = [&](SceneObject object, double path_gap, double reach, double gap, double turn) {
    for (int attempt = 0; attempt < 60; ++attempt) {
      const Station at = along(chance.between(0, length));
      const double aside = (chance.below(2) ? 1 : -1) * (path_gap + object.radius() + chance.between(0.02, reach));
      object.x = at.x + aside * std::cos(at.heading);
      object.z = at.z + aside * std::sin(at.heading);
      if (turn < 9) object.yaw = at.heading + turn;
      const bool inside = std::max(std::abs(object.x - middle_x_), std::abs(object.z - middle_z_)) < half - 0.6 - object.radius();
      if (inside && fits(object, path_gap, gap)) return objects_.push_back(object);
    }
  };
  for (int i = 0; i < 4; ++i)
    place(make(ObjectKind::wall, 0, 0, chance.between(1.4, 2.6), 0.25, chance.between(0.8, 1.2), 0, 140), 0.9, 1.2, 0.4,
          i % 2 ? M_PI / 2 : 0.2);
  for (int i = 0; i < 52; ++i) place(random_object(chance), 0.8, i % 2 ? 1.0 : 2.4, 0.3, 9);
  for (int i = 0; i < 14; ++i) place(small_object(chance), 0.25, 1.0, 0.15, 9);
}

bool Scene::hides(const SceneObject& object) const {
  const auto side = [](const SceneObject& o, double sign) { return (o.x + sign * o.radius()) / std::max(0.3, o.z); };
  return std::any_of(objects_.begin(), objects_.end(), [&](const SceneObject& other) {
    const double overlap = std::min(side(object, 1), side(other, 1)) - std::max(side(object, -1), side(other, -1));
    const double narrower = std::min(side(object, 1) - side(object, -1), side(other, 1) - side(other, -1));
    return overlap > 0.25 * narrower;
  });
}

void Scene::build_flat(Chance& chance) {
  const int large = 2 + chance.below(5), small = 1 + chance.below(2);
  const auto place = [&](SceneObject object) {
    for (int attempt = 0; attempt < 200; ++attempt) {
      object.z = chance.between(1.3 + object.radius(), 5);
      object.x = chance.between(-0.48, 0.48) * object.z;
      if (fits(object, 0, 0.15) && !hides(object)) return objects_.push_back(object);
    }
  };
  for (int i = 0; i < large; ++i) {
    // The first is always of a size that must be found.
    SceneObject object = random_object(chance);
    while (i == 0 && std::min(object.width, object.height) < 0.3) object = random_object(chance);
    if (i == 1 && chance.below(2))
      object = make(ObjectKind::wall, 0, 0, chance.between(0.8, 1.6), 0.2, chance.between(0.5, 1.1), chance.between(-0.5, 0.5), 140);
    place(object);
  }
  for (int i = 0; i < small; ++i) place(small_object(chance));
}

/// What has edges and no texture; with every other seed also a gate: two posts side by side with nothing between them.
void Scene::build_blank(Chance& chance) {
  double middle = 0, half_gate = 0;
  if (parameters_.seed % 2 == 0) {
    const double z = chance.between(2.4, 4), tall = chance.between(0.7, 1.4);
    middle = chance.between(-0.2, 0.2);
    half_gate = chance.between(0.25, 0.45);
    for (const double x : {middle * z - half_gate, middle * z + half_gate})
      objects_.push_back(make(ObjectKind::post, x, z, 0.14, 0.14, tall, 0, chance.between(60, 190)));
  }
  for (int i = 0; i < 3; ++i) {
    SceneObject object = make(ObjectKind::box, 0, 0, chance.between(0.3, 0.8), chance.between(0.3, 0.6), chance.between(0.3, 0.9),
                              chance.between(-0.8, 0.8), chance.between(40, 230));
    if (i == 0 && chance.below(2))
      object = make(ObjectKind::wall, 0, 0, chance.between(0.8, 1.6), 0.2, chance.between(0.5, 1.1), chance.between(-0.5, 0.5), 200);
    object.textured = false;
    for (int attempt = 0; attempt < 200; ++attempt) {
      object.z = chance.between(1.5 + object.radius(), 4.5);
      object.x = chance.between(-0.4, 0.4) * object.z;
      const double aside = std::abs(object.x - middle * object.z) - object.radius();
      if ((half_gate > 0 && aside < half_gate + 0.1) || !fits(object, 0, 0.15) || hides(object)) continue;
      objects_.push_back(object);
      break;
    }
  }
}

void Scene::build_five() {
  objects_ = {make(ObjectKind::box, -0.45, 1.9, 0.35, 0.3, 0.35, 0.3, 150), make(ObjectKind::post, 0.35, 2.4, 0.16, 0.16, 1.1, 0, 170),
              make(ObjectKind::rock, 0.95, 2.9, 0.6, 0.5, 0.4, 0.2, 140), make(ObjectKind::box, -1.25, 3.5, 0.8, 0.5, 0.9, -0.35, 130),
              make(ObjectKind::wall, 0.5, 4.6, 1.5, 0.25, 1.0, -0.15, 140)};
}

}  // namespace vdisp::sim
