// ride.cpp: motion in small steps until something is met.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/ride.h"

#include <algorithm>

namespace vdisp::sim {

Ride::Ride(const sim_section& parameters, const World& world)
    : who_(parameters.drive == "expert"    ? Who::expert
           : parameters.drive == "command" ? Who::command
                                           : Who::nobody),
      seconds_(static_cast<double>(frame_period_ns(parameters)) * 1e-9),
      plan_(world.objects, world.panes, world.walkers.size(), static_cast<uint32_t>(parameters.seed)),
      reach_(plan_, {}, world.middle, world.extent, refuge_room),
      people_(world.walkers),
      expert_(static_cast<uint64_t>(parameters.seed), parameters.exploration),
      chance_(static_cast<uint64_t>(parameters.seed) + 0x57ac4) {
  plan_.place_people(people_.spots());
  expert_.judge(plan_, robot_, 0);
  tell(false, false);
}

void Ride::step(const Order& order) {
  const std::vector<Spot>& places = reach_.places();
  if (free_again_ && !places.empty()) put(places[static_cast<size_t>(chance_.below(static_cast<int>(places.size())))]);
  if (put_back_) put(refuge_);
  free_again_ = put_back_ = false;
  people_.step(seconds_, robot_.spot);
  plan_.place_people(people_.spots());
  switch (who_) {
    case Who::nobody: break;
    case Who::expert: move(expert_.drive(plan_, robot_, seconds_)); break;
    case Who::command: move(order); break;
  }
  if (who_ != Who::nobody) watch_progress();
  expert_.judge(plan_, robot_, seconds_);
  tell(put_back_, free_again_);
}

/// A collision ends the frame's motion at the last place before it; from there it is put back in the next.
void Ride::move(const Order& order) {
  constexpr double longest = 0.01;  // s: 5 mm at 0.5 m/s
  const int steps = std::max(1, static_cast<int>(std::ceil(seconds_ / longest - 1e-9)));
  for (int i = 0; i < steps; ++i) {
    const Robot before = robot_;
    robot_.move(order, seconds_ / steps);
    // What moves into a robot that stands is not its collision.
    const FloorPlan::Thing* met = robot_.stands() ? nullptr : plan_.met(robot_.outline());
    if (met) {
      robot_ = before;
      robot_.stop();
      put_back_ = true;
      ++report_.collisions;
      report_.met = met->what;
      return;
    }
    report_.travelled += distance(before.spot, robot_.spot);
  }
}

void Ride::watch_progress() {
  if (!put_back_ && plan_.gap(robot_.spot, refuge_room) >= refuge_room) refuge_ = robot_.spot;
  unmoved_ += seconds_;
  if (distance(robot_.spot, anchor_) > stuck_within) {
    anchor_ = robot_.spot;
    unmoved_ = 0;
  }
  if (unmoved_ < stuck_after) return;
  free_again_ = true;
  unmoved_ = 0;
  ++report_.stuck_times;
}

/// At rest, and turned to where the way is longest.
void Ride::put(const Spot& spot) {
  robot_ = Robot();
  robot_.spot = anchor_ = spot;
  unmoved_ = 0;
  double longest = -1;
  for (int i = 0; i < 36; ++i) {
    const double heading = std::remainder(i * M_PI / 18, 2 * M_PI), way = plan_.way(spot, heading, Expert::half_strip, 10);
    if (way > longest) {
      longest = way;
      robot_.heading = heading;
    }
  }
}

void Ride::tell(bool collided, bool stuck) {
  const Expert::Judgement& judgement = expert_.judgement();
  report_.x = robot_.spot.z;
  report_.y = -robot_.spot.x;
  report_.yaw = robot_.heading;
  report_.speed = robot_.speed();
  report_.turn_rate = robot_.turn_rate();
  report_.clearance = plan_.gap(robot_.outline(), 5);
  report_.collided = collided;
  report_.stuck = stuck;
  report_.steering = judgement.steering;
  report_.clearness = judgement.clearness;
  report_.since_s = judgement.since;
  report_.changes = judgement.changes;
}

}  // namespace vdisp::sim
