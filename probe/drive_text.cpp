// drive_text.cpp: one function a record.
// SPDX-License-Identifier: Apache-2.0
#include "probe/drive_text.h"

#include "ipc/records.h"
#include "probe/format.h"

namespace vdisp {
namespace {

const char* steering_words(Steering steering) {
  switch (steering) {
    case Steering::forward: return "forward";
    case Steering::turn_left: return "turn left";
    case Steering::turn_right: return "turn right";
    case Steering::count: break;
  }
  return "a state this version does not know";
}

const char* decider_words(Decider decider) {
  switch (decider) {
    case Decider::none: return "nobody";
    case Decider::vdisparity: return "the map (v-disparity)";
    case Decider::snow: return "the classifiers (SNoW)";
    case Decider::operator_order: return "the operator";
    case Decider::count: break;
  }
  return "one this version does not know";
}

std::vector<std::string> scores_text(const SnowScores& s) {
  const bool free = s.free_difference + s.obstacle_sensitivity > 0, left = s.left_difference + s.direction_sensitivity > 0;
  return {std::string("way         ") + (free ? "free" : "obstacle"),
          "obstacle    " + or_dash("free %.3f", s.free) + or_dash(", obstacle %.3f", s.obstacle) + or_dash(": %+.4f", s.free_difference) +
              or_dash(", sensitivity %+.4f", s.obstacle_sensitivity) + or_dash(", clear from %.4f", s.clear),
          std::string("to evade    ") + (left ? "left" : "right"),
          "direction   " + or_dash("left %.3f", s.left) + or_dash(", right %.3f", s.right) + or_dash(": %+.4f", s.left_difference) +
              or_dash(", sensitivity %+.4f", s.direction_sensitivity),
          format("features    %u active", s.active)};
}

std::vector<std::string> decision_text(const Decision& d) {
  return {std::string("decision    ") + steering_words(d.steering), std::string("by          ") + decider_words(d.decider),
          "clearness   " + or_dash("%.0f %%", d.clearness, 100), "since       " + or_dash("%.1f s", d.since_s),
          "changes     " + std::to_string(d.changes)};
}

std::vector<std::string> command_text(const DriveCommand& c) {
  std::vector<std::string> lines{"speed       " + or_dash("%.3f m/s", c.speed), "turn rate   " + or_dash("%+.3f rad/s", c.turn_rate),
                                 std::string("by          ") + decider_words(c.decider),
                                 std::string("decision    ") + steering_words(c.steering)};
  if (c.valid_until_ns) lines.push_back("until       " + std::to_string(c.valid_until_ns / 1'000'000) + " ms of the monotonic clock");
  if (c.slowed) lines.push_back("slowed      the detectors disagree, or one decided alone");
  return lines;
}

std::vector<std::string> check_text(const CrossCheck& c) {
  const auto words = [](uint32_t free) { return free ? "free" : "not free"; };
  std::vector<std::string> lines{std::string("map         ") + words(c.map_free) + or_dash(", %.2f m", c.corridor_m),
                                 std::string("classifier  ") + words(c.snow_free),
                                 c.agree ? "they        agree" : "they        disagree since" + or_dash(" %.1f s", c.disagreeing_s),
                                 "agreed      " + std::to_string(c.agreed) + " frames",
                                 "only map    free in " + std::to_string(c.only_map_free),
                                 "only SNoW   free in " + std::to_string(c.only_snow_free)};
  return lines;
}

}  // namespace

std::vector<std::string> drive_text(const Image& image) {
  if (const SnowScores* scores = record_of<SnowScores>(image)) return scores_text(*scores);
  if (const Decision* decision = record_of<Decision>(image)) return decision_text(*decision);
  if (const DriveCommand* command = record_of<DriveCommand>(image)) return command_text(*command);
  if (const CrossCheck* check = record_of<CrossCheck>(image)) return check_text(*check);
  return {};
}

}  // namespace vdisp
