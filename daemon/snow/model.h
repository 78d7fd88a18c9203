// model.h: a trained pair of classifiers in a file: what it was trained with, and dense weights that are used as they lie there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/snow/network.h"
#include "daemon/snow/private_copy.h"

namespace vdisp::snow {

enum class Smooth : uint32_t { none = 0, mean, median };

/// The front end that the features came from. A model is of use with the same one only.
struct Settings {
  Encoding encoding = Encoding::depth_map;
  uint32_t width = 320, height = 240;  ///< px, of the views that are matched
  uint32_t disparities = 32;           ///< px, search width
  uint32_t block = 9;                  ///< px, side of what is compared
  Smooth smooth = Smooth::mean;
  double confidence = 0;  ///< as in [census]
  bool operator==(const Settings&) const = default;
};

/// One classifier: how it was trained, and what it is worth.
struct Trained {
  Winnow winnow;
  double initial = 0;              ///< weight of a new link, as it was
  double sensitivity = 0;          ///< part of theta; (first - second) / theta + sensitivity > 0 is the first class
  double clear = 1;                ///< above 0, part of theta: difference of half of those of the first class that look so
  double auc = 0;                  ///< on recordings held apart; NaN: there were none
  uint64_t first = 0, second = 0;  ///< examples trained with: free and obstacle, or left and right
  uint32_t passes[2] = {};         ///< that were run, for each target
};

/// One line: file, what was found, what would be right. exit_code: 66 no such file, 78 it is wrong, 73 or 74 it cannot be written.
class ModelError : public std::runtime_error {
 public:
  ModelError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// A recording that a model was trained with. weight: times that each example was seen in a pass.
struct Source {
  std::string folder;
  uint32_t weight = 1;
  bool held_apart = false;  ///< judged on, not trained with
  bool operator==(const Source&) const = default;
};

/// What a file is made of. The spans hold vector_length weights each.
struct ModelParts {
  Settings settings;
  Trained obstacle, direction;
  std::span<const float> free, obstacles, left, right;
  std::vector<Source> sources;
};

/// Writes it beside the place, whole, onto the disk, and renames it: a reader finds the old one or the new one. Throws ModelError and
/// leaves the old one.
void write_model(const std::filesystem::path& path, const ModelParts& parts);

/// A model that was in a file when it was opened. What becomes of the file afterwards does not matter: the bytes are a copy, and it is the
/// copy that was checked.
class Model {
 public:
  /// Checks magic, version, sizes and checksums of all of it. Throws ModelError.
  static Model open(const std::filesystem::path& path);

  const Settings& settings() const;
  const Trained& obstacle_training() const;   ///< first = free, second = obstacle
  const Trained& direction_training() const;  ///< first = left, second = right
  const std::vector<Source>& sources() const { return sources_; }
  /// Throws ModelError, naming all that differs, unless it was trained with this front end. `where`: whose settings they are, as [census].
  void require(const Settings& wanted, const std::string& where) const;

  /// Activations of both targets. ids: as from feature_ids; each below vector_length.
  struct Scores {
    double first, second;
  };
  Scores obstacle(std::span<const uint32_t> ids) const noexcept;
  Scores direction(std::span<const uint32_t> ids) const noexcept;
  /// (first - second) / theta, without sensitivity.
  static double difference(const Scores& scores, const Trained& trained) { return (scores.first - scores.second) / trained.winnow.theta; }
  /// Of target 0 free, 1 obstacle, 2 left, 3 right.
  std::span<const float> weights(int target) const noexcept;

 private:
  Model() = default;
  std::filesystem::path path_;
  PrivateCopy copy_;
  std::vector<Source> sources_;
};

/// What differs, for people: "block is 9 and not 7, ..."; empty: nothing.
std::string differences(const Settings& found, const Settings& wanted);

}  // namespace vdisp::snow
