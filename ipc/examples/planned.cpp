// planned.cpp: what planning in a changing map costs, and what planning anew would have cost.
// SPDX-License-Identifier: Apache-2.0
#include "planned.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace planner {
namespace {

double us_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Plan Planner::plan(const vdisp::Image& occupancy, const vdisp::Image& changes) {
  Plan plan;
  // Where camera or odometry frame lie in the rover's is told by the grid: both are planned in alike.
  if (occupancy.grid.frame > vdisp::grid_of_odometry) {
    map_.forget();
    plan.why = "the map is in a frame that this example does not know";
    return plan;
  }
  plan.read = map_.follow(&occupancy, &changes);
  if (plan.read == Read::refused) {
    plan.why = "the images are no map and its changes";
    return plan;
  }
  feed(plan);
  if (compare_) compare(plan);
  find_way(plan);
  return plan;
}

void Planner::feed(Plan& plan) {
  const auto start = std::chrono::steady_clock::now();
  if (!navigation_ || navigation_->rows() != map_.rows() || navigation_->columns() != map_.columns())
    navigation_.emplace(map_.rows(), map_.columns());
  const Place wanted = grid_place(map_.grid(), target_.x, target_.y);
  const Cell goal = nearest_cell(wanted);
  plan.goal_outside = !(goal == cell_at(wanted));
  plan.forgot = map_.changed().size() * repaired > static_cast<size_t>(map_.rows()) * static_cast<size_t>(map_.columns());
  if (plan.forgot || !(goal == navigation_->goal())) navigation_->set_goal(goal);
  for (const Cell& cell : map_.changed()) navigation_->set_speed(cell, map_.speed(cell));
  plan.fed = map_.changed().size();
  plan.calculated = navigation_->propagate();
  plan.took_us = us_since(start);
}

void Planner::compare(Plan& plan) const {
  const auto start = std::chrono::steady_clock::now();
  Navigation anew(map_.rows(), map_.columns());
  for (int row = 0; row < map_.rows(); ++row) {
    for (int column = 0; column < map_.columns(); ++column) anew.set_speed({row, column}, map_.speed({row, column}));
  }
  anew.set_goal(navigation_->goal());
  anew.propagate();
  plan.anew_us = us_since(start);
  for (int row = 0; row < map_.rows(); ++row) {
    for (int column = 0; column < map_.columns(); ++column)
      plan.as_anew = plan.as_anew && anew.cost({row, column}) == navigation_->cost({row, column});
  }
}

void Planner::find_way(Plan& plan) const {
  // The rover's origin often lies behind the first row of the map: the way begins in the cell nearest to it.
  const Place rover = grid_place(map_.grid(), 0, 0);
  const Cell start = nearest_cell(rover);
  plan.way = navigation_->path(start == cell_at(rover) ? rover : centre_of(start));
  if (!plan.way.empty())
    plan.cost_m = navigation_->cost(start) * static_cast<double>(map_.grid().cell);
  else if (!(navigation_->speed(navigation_->goal()) > 0))
    plan.why = "the goal is no ground to drive on";
  else if (!(navigation_->speed(start) > 0))
    plan.why = "the rover stands where it may not drive";
  else
    plan.why = "all ways to the goal are blocked";
}

Cell Planner::nearest_cell(const Place& place) const {
  const auto within = [](double value, int size) { return static_cast<int>(std::floor(std::clamp(value, 0.0, size - 0.5))); };
  return {within(place.row, map_.rows()), within(place.column, map_.columns())};
}

}  // namespace planner
