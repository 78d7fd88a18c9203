// people.cpp: steps along polylines, and four shapes for each person.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/people.h"

#include <algorithm>

namespace vdisp::sim {

People::People(std::vector<Walker> walkers) : walkers_(std::move(walkers)), states_(walkers_.size()), spots_(walkers_.size()) {
  for (size_t i = 0; i < walkers_.size(); ++i) {
    State& state = states_[i];
    double length = 0;
    const std::vector<Spot>& way = walkers_[i].way;
    for (size_t k = 0; k < way.size(); ++k) {
      if (k > 0) length += distance(way[k - 1], way[k]);
      state.lengths.push_back(length);
    }
    state.along = std::clamp(walkers_[i].start, 0.0, length);
    settle(i);
  }
}

/// Spot and heading from the length walked.
void People::settle(size_t i) {
  State& state = states_[i];
  const std::vector<Spot>& way = walkers_[i].way;
  const auto next = std::upper_bound(state.lengths.begin(), state.lengths.end() - 1, state.along);
  const size_t b = std::max<size_t>(1, static_cast<size_t>(next - state.lengths.begin())), a = b - 1;
  const double length = state.lengths[b] - state.lengths[a], part = length > 0 ? (state.along - state.lengths[a]) / length : 0;
  spots_[i] = {way[a].x + (way[b].x - way[a].x) * part, way[a].z + (way[b].z - way[a].z) * part};
  state.heading = std::atan2(-(way[b].x - way[a].x) * state.sign, (way[b].z - way[a].z) * state.sign);
}

void People::step(double seconds, const Spot& robot) {
  for (size_t i = 0; i < walkers_.size(); ++i) {
    State& state = states_[i];
    const Spot along = towards(state.heading), to{robot.x - spots_[i].x, robot.z - spots_[i].z};
    const double ahead = to.x * along.x + to.z * along.z, aside = std::abs(to.x * along.z - to.z * along.x);
    if (ahead > -0.1 && ahead < respect && aside < 0.65) {
      state.waited += seconds;
      if (state.waited < patience) continue;
      state.sign = -state.sign;
    }
    state.waited = 0;
    const double step = walkers_[i].speed * seconds, end = state.lengths.back();
    state.along += state.sign * step;
    state.walked += step;
    if (state.along >= end || state.along <= 0) state.sign = -state.sign;
    state.along = std::clamp(state.along, 0.0, end);
    settle(i);
  }
}

void People::draw(std::span<SceneObject> figures) const {
  constexpr double stride = 0.7, swing = 0.2, hip = 0.1;  // m
  for (size_t i = 0; i < walkers_.size(); ++i) {
    const State& state = states_[i];
    const Spot along = towards(state.heading), right{along.z, -along.x};
    const double leg = swing * std::sin(M_PI * state.walked / stride);
    for (size_t part = 0; part < parts; ++part) {
      SceneObject& o = figures[i * parts + part];
      const double side = part == 0 ? hip : part == 1 ? -hip : 0, ahead = part == 0 ? leg : part == 1 ? -leg : 0;
      o.x = spots_[i].x + right.x * side + along.x * ahead;
      o.z = spots_[i].z + right.z * side + along.z * ahead;
      o.yaw = state.heading;
      o.kind = ObjectKind::post;
      o.width = part < 2 ? 0.16 : part == 2 ? 0.46 : 0.19;
      o.depth = part < 2 ? 0.18 : part == 2 ? 0.27 : 0.22;
      o.bottom = part < 2 ? 0 : part == 2 ? 0.82 : 1.46;
      o.height = part < 2 ? 0.85 : part == 2 ? 1.46 : 1.75;
      o.surface = part < 2 ? Surface::bark : Surface::stone;
      o.brightness = part == 3 ? 150 : part == 2 ? walkers_[i].brightness : 200 - walkers_[i].brightness;
    }
  }
}

}  // namespace vdisp::sim
