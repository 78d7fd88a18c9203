// words.h: the words of vdisp-train, what they are asked, and how they fail.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/snow/model.h"

namespace vdisp::train {

/// One line: what was found, where, what would be right.
class ToolError : public std::runtime_error {
 public:
  ToolError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// All there are.
inline std::vector<std::string> encoding_names() {
  std::vector<std::string> names;
  for (const snow::Encoding encoding : snow::encodings) names.emplace_back(name(encoding));
  return names;
}

/// What of Settings and Winnow the command line says; the rest is that of the model that is added to, or the default.
struct Chosen {
  std::string encoding, smooth, size;
  std::optional<uint32_t> disparities, block, passes, seed;
  std::optional<double> confidence, theta, alpha, beta, initial, above, below;
};

/// What tune tries: each with each.
struct Grid {
  std::vector<uint32_t> blocks{5, 7, 9, 13}, widths{32, 48};
  std::vector<double> confidences{0.4, 0.8, 1.2}, thick{0, 0.2};
  std::vector<std::string> smooths{"none", "mean", "median"}, encodings = encoding_names();
  size_t trials = 0;    ///< front ends at most, 0: all
  size_t pairs = 4000;  ///< of all recordings together, thinned evenly
  std::string table = "tune.csv";
};

struct Options {
  std::vector<std::string> folders, test, add;
  std::string model, output, config;
  uint32_t add_weight = 3;
  double hold_out = 0.2;
  uint32_t split_seed = 1;
  Chosen chosen;
  std::optional<double> obstacle_sensitivity, direction_sensitivity;
  std::optional<double> detection;  ///< chooses the obstacle classifier's sensitivity
  bool compare = false, obstacle_only = false, json = false;
  std::string plots;  ///< folder; empty: none
  int threads = 2;
  Grid grid;
};

/// Each returns the exit code, and throws ToolError, ModelError, RecordingError or WriteError.
int train(const Options& options);
int evaluate(const Options& options);
int tune(const Options& options);

/// [census] of a vdisp.cfg, or its defaults where `config` is empty, for views of 320x240. Throws ToolError (66, 77, 78).
snow::Settings census_of(const std::string& config);
/// The front end and the network that are asked for, over what they are else. Throws ToolError (64).
snow::Settings settings_of(const Chosen& chosen, snow::Settings base);
snow::Winnow winnow_of(const Chosen& chosen, snow::Winnow base = {});
snow::Smooth smooth_named(const std::string& name);

/// "1 recording", "2 recordings".
inline std::string counted(size_t count, const std::string& what) { return std::to_string(count) + " " + what + (count == 1 ? "" : "s"); }

}  // namespace vdisp::train
