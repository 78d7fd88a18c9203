// planned.h: one frame of the map to one plan: feed what changed, bring the costs up to date, go down to the goal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "followed_map.h"
#include "navigation.h"

namespace planner {

/// A point of the rover's frame: x ahead, y left, m.
struct Point {
  double x = 0, y = 0;
};

struct Plan {
  Read read = Read::refused;
  size_t fed = 0;             ///< cells whose speed changed
  bool forgot = false;        ///< so many that calculating all costs is faster than repairing them
  size_t calculated = 0;      ///< cells whose cost was calculated
  double took_us = 0;         ///< for all of that
  double anew_us = 0;         ///< planning anew with the same speeds took this long; 0: not asked for
  bool as_anew = true;        ///< and had the same costs
  bool goal_outside = false;  ///< the goal lies outside the map: the way leads to the nearest cell of its border
  double cost_m = 0;          ///< of the way, as m of free ground
  std::vector<Place> way;     ///< empty: there is none, see `why`
  const char* why = "";
};

class Planner {
 public:
  /// Costs are repaired where at most one cell in so many has another speed. Where more have, scattered over the map, nearly all costs
  /// change, and each is calculated twice, once forgotten and once found: 0.5 ms against 0.4 ms anew for 50 of 2550 cells.
  static constexpr size_t repaired = 50;

  /// `compare`: plans anew in each frame as well.
  Planner(const Point& goal, const Policy& policy, bool compare) : target_(goal), map_(policy), compare_(compare) {}
  /// `occupancy` and `map_changes` of one frame.
  Plan plan(const vdisp::Image& occupancy, const vdisp::Image& changes);
  /// The map is blind, stale or dead: nothing is known until a frame is read whole.
  void forget() { map_.forget(); }
  const FollowedMap& map() const { return map_; }

 private:
  void feed(Plan& plan);
  void compare(Plan& plan) const;
  void find_way(Plan& plan) const;
  Cell nearest_cell(const Place& place) const;

  Point target_;
  FollowedMap map_;
  bool compare_;
  std::optional<Navigation> navigation_;
};

}  // namespace planner
