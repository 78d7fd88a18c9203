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
  tell();
}

void Ride::step(const Order& order) {
  people_.step(seconds_, robot_.spot);
  plan_.place_people(people_.spots());
  report_.collided = report_.stuck = false;
  // An order is made of the picture before: it does not count where the robot is put somewhere else.
  if (due_ != Due::nothing)
    put();
  else if (who_ != Who::nobody) {
    move(who_ == Who::expert ? expert_.drive(plan_, robot_, seconds_) : order);
    watch_progress();
  }
  expert_.judge(plan_, robot_, seconds_);
  tell();
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
      due_ = Due::refuge;
      report_.collided = true;
      ++report_.collisions;
      report_.met = met->what;
      return;
    }
    report_.travelled += distance(before.spot, robot_.spot);
  }
}

void Ride::watch_progress() {
  if (due_ == Due::nothing && has_room(robot_.spot)) refuge_ = robot_.spot;
  unmoved_ += seconds_;
  if (distance(robot_.spot, anchor_) > stuck_within) {
    anchor_ = robot_.spot;
    unmoved_ = 0;
  }
  if (unmoved_ < stuck_after) return;
  due_ = Due::anywhere;
  unmoved_ = 0;
  report_.stuck = true;
  ++report_.stuck_times;
}

bool Ride::has_room(const Spot& spot) const { return plan_.gap(spot, refuge_room) >= refuge_room; }

/// Where people stand there is no room now: it waits.
void Ride::put() {
  if (due_ == Due::refuge) {
    if (has_room(refuge_)) put(refuge_);
    return;
  }
  const std::vector<Spot>& places = reach_.places();
  if (places.empty()) due_ = Due::nothing;
  const size_t first = static_cast<size_t>(chance_.below(static_cast<int>(places.size())));
  for (size_t i = 0; i < places.size() && due_ != Due::nothing; ++i) {
    const Spot& spot = places[(first + i) % places.size()];
    if (has_room(spot)) put(spot);
  }
}

/// At rest, and turned to where the way is longest.
void Ride::put(const Spot& spot) {
  due_ = Due::nothing;
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

void Ride::tell() {
  const Expert::Judgement& judgement = expert_.judgement();
  report_.x = robot_.spot.z;
  report_.y = -robot_.spot.x;
  report_.yaw = robot_.heading;
  report_.speed = robot_.speed();
  report_.turn_rate = robot_.turn_rate();
  report_.clearance = plan_.gap(robot_.outline(), 5);
  report_.steering = judgement.label;
  report_.clearness = judgement.clearness;
  report_.since_s = judgement.since;
  report_.changes = judgement.changes;
}

}  // namespace vdisp::sim
