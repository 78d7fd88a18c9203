// drive.h: what the detectors decide and what the rover is told: scores, state, command, and how far two detectors agree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// The paper's three states (census + SNoW, figure 10).
enum class Steering : uint32_t { forward = 0, turn_left, turn_right, count };

/// Who decided.
enum class Decider : uint32_t { none = 0, vdisparity, snow, operator_order, count };

/// `snow`: activations of both classifiers' targets (equation 3), and what is decided by: difference + sensitivity > 0 is the first class.
struct SnowScores {
  static constexpr RecordType type = RecordType::snow_scores;
  static constexpr uint16_t version = 2;
  RecordHeader header;
  double free, obstacle;         ///< obstacle classifier
  double left, right;            ///< direction classifier
  double free_difference;        ///< free - obstacle, over the threshold: comparable between models
  double left_difference;        ///< left - right, likewise
  double obstacle_sensitivity;   ///< of the model, or of [snow]
  double direction_sensitivity;  ///< likewise
  uint32_t encoding;             ///< as in the model
  uint32_t active;               ///< active features
  double clear;                  ///< nothing is near from this difference + sensitivity on: of the model, times [snow] clear
};

/// `decision`: the state machine's state. Blind: nobody knows; never forward.
struct Decision {
  static constexpr RecordType type = RecordType::decision;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  Steering steering;
  Decider decider;
  double clearness;  ///< 0 = as near as the rover may come, 1 = nothing is near: what speed is derived from
  double since_s;    ///< how long the steering is this one
  uint64_t changes;  ///< of the steering, since the start or the event `recording`
};

/// `drive`: what the rover is to do now, and until timeout without a newer one, or until its own end if that comes first. Blind: stop.
struct DriveCommand {
  static constexpr RecordType type = RecordType::drive_command;
  static constexpr uint16_t version = 2;
  RecordHeader header;
  double speed, turn_rate;  ///< m/s ahead, rad/s to the left
  Steering steering;        ///< of the decision, also where the operator overrides it
  Decider decider;          ///< operator_order: in/drive won
  uint32_t slowed;          ///< 1: the detectors disagree, or one decided alone, so slower than the decision would be
  uint32_t unused;
  int64_t valid_until_ns;  ///< CLOCK_MONOTONIC: stop then, whatever the timeout (the operator's dead-man); 0: no end of its own
};

/// `cross_check`: the map's way ahead against the classifier. Counts are since the start or the event `recording`, of frames where both
/// could see.
struct CrossCheck {
  static constexpr RecordType type = RecordType::cross_check;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint32_t agree;      ///< 1: both free, or both not
  uint32_t map_free;   ///< 1: the map's corridor is free as far as `corridor_m`
  uint32_t snow_free;  ///< 1: the classifier says free
  uint32_t unused;
  double corridor_m;     ///< to the first obstacle or unknown ground in the corridor
  double disagreeing_s;  ///< without a pause, until now
  uint64_t agreed, only_map_free, only_snow_free;
};

static_assert(sizeof(SnowScores) == 88 && sizeof(Decision) == 40 && sizeof(DriveCommand) == 48 && sizeof(CrossCheck) == 64);

/// One word for files, one phrase for people.
std::string_view name(Steering steering);
std::string_view name(Decider decider);

}  // namespace vdisp
