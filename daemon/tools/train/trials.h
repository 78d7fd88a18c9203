// trials.h: the table of what tune tried: a line for each trial, kept as soon as it is known, so that a search can be taken up again.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "daemon/snow/model.h"

namespace vdisp::train {

/// What was tried, and what came of it on the recordings held apart.
struct Trial {
  snow::Settings settings;
  double thick = 0;  ///< both sides of the separator
  double obstacle_auc = 0, direction_auc = 0;
  double obstacle_sensitivity = 0, direction_sensitivity = 0;  ///< where detection - false acceptance is greatest

  bool same_question(const Trial& other) const { return settings == other.settings && thick == other.thick; }
  /// What is searched for.
  double worth() const { return obstacle_auc + direction_auc; }
};

class TrialTable {
 public:
  /// Reads what is there, or begins the file. `question` is what all trials have in common (recordings, split, network): a table of
  /// another one is refused. A line that was cut off is dropped. Throws ToolError (66, 73, 74, 78).
  TrialTable(std::string path, const std::string& question);
  ~TrialTable();
  TrialTable(const TrialTable&) = delete;
  TrialTable& operator=(const TrialTable&) = delete;

  const std::vector<Trial>& trials() const { return trials_; }
  bool has(const Trial& trial) const;
  /// Appended and on the disk when it returns.
  void add(const Trial& trial);

 private:
  void read(std::string text, const std::string& question);

  std::string path_;
  int file_ = -1;
  std::vector<Trial> trials_;
};

/// Best first, for people.
std::string text_of(std::vector<Trial> trials);

}  // namespace vdisp::train
