// feature_table.h: the features of all samples, computed once and kept in memory, a byte each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <vector>

#include "daemon/snow/network.h"
#include "daemon/tools/train/drives.h"

namespace vdisp::train {

/// Pixels of the feature images: their numbers follow from place and value, in a quarter of the memory.
class FeatureTable {
 public:
  /// Runs the front end over all samples, shared by `threads`, and makes the features of these encodings. `settings.encoding` does not
  /// matter. Throws what FrontEnd throws.
  FeatureTable(const Drives& drives, const snow::Settings& settings, std::span<const snow::Encoding> encodings, int threads);

  /// The features' numbers; `ids` has active_features(encoding) places.
  std::span<const uint32_t> ids(snow::Encoding encoding, uint32_t sample, std::span<uint32_t> ids) const;
  /// Where the daemon would be blind: too dark, too bright, nothing matched. There are no features.
  bool blind(uint32_t sample) const { return blind_[sample]; }
  /// Samples that are not blind, held apart or not.
  std::vector<uint32_t> numbers(const Drives& drives, bool held_apart) const;
  size_t blind_count() const;
  /// Of those that numbers() gives.
  Classes classes(const Drives& drives, bool held_apart) const;
  /// As Drives::require_classes, of those alone: the blind ones may have been all of a class.
  void require_classes(const Drives& drives, bool held_apart, bool obstacle_only) const {
    drives.require(classes(drives, held_apart), held_apart, obstacle_only, " with which the daemon would not be blind");
  }

 private:
  struct Columns {
    size_t bytes;  // of a sample
    std::vector<uint8_t> pixels;
  };
  std::map<snow::Encoding, Columns> columns_;
  std::vector<uint8_t> blind_;
};

}  // namespace vdisp::train
