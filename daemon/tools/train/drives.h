// drives.h: labelled recordings, and which of them are trained with and which are judged on: never both, as one folder is one drive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "daemon/snow/model.h"
#include "ipc/recording.h"

namespace vdisp::train {

/// A labelled pair of a recording.
struct Sample {
  uint32_t drive, pair;
  Label label;  ///< forward, left or right
};

/// How many pairs have each label.
struct Classes {
  size_t forward = 0, left = 0, right = 0;
  size_t all() const { return forward + left + right; }
  void add(Label label) { ++(label == Label::forward ? forward : label == Label::left ? left : right); }
  /// "forward and right", or empty: what there is none of.
  std::string missing() const;
};

struct Drives {
  std::vector<Recording> recordings;
  std::vector<snow::Source> sources;  ///< one for each recording
  std::vector<Sample> samples;        ///< of all, one recording after the other
  size_t unlabelled = 0, cut_off = 0;

  bool held_apart(const Sample& sample) const { return sources[sample.drive].held_apart; }
  Classes classes(bool held_apart) const;
  /// Throws ToolError (66) unless there are pairs of all three labels, naming what is missing: one class teaches nothing, and judges
  /// nothing.
  /// `obstacle_only`: left or right will do.
  void require_classes(bool held_apart, bool obstacle_only = false) const { require(classes(held_apart), held_apart, obstacle_only, ""); }
  /// The same of those that `found` counts; `which`: what they have in common, after "pair".
  void require(const Classes& found, bool held_apart, bool obstacle_only, const std::string& which) const;
  /// Drives that are held apart, or not.
  size_t count(bool held_apart) const;
  /// Numbers of the samples that are held apart, or not.
  std::vector<uint32_t> numbers(bool held_apart) const;
  /// Leaves out samples so that about `most` remain: every n-th of each recording.
  void thin(size_t most);
};

/// Which world of the simulator a recording is of, such as "office, seed 4"; empty: of none. Throws RecordingError.
std::string world_of(const std::string& folder);

/// Opens them all. A folder named twice, by whatever path, is refused, and so is a world of the simulator on both sides. Throws
/// RecordingError, ToolError (64).
Drives open_drives(std::vector<snow::Source> sources);

/// Sources for folders on a command line: absolute, so that a model's list holds wherever it is read. Throws ToolError (66).
std::vector<snow::Source> sources_of(std::span<const std::string> folders, uint32_t weight, bool held_apart);

/// Holds about this part of the drives apart, at least one, by chance; those of another weight than 1 (collisions) never. `worlds`: as from
/// world_of, of each source; drives of one world go together. Throws ToolError (66) where none remains on one side.
void hold_out(std::vector<snow::Source>& sources, std::span<const std::string> worlds, double part, uint32_t seed);
std::vector<std::string> worlds_of(std::span<const snow::Source> sources);

}  // namespace vdisp::train
