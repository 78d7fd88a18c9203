// network.h: SNoW as published: a Sparse Network of Winnows, two targets that learn from their mistakes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "daemon/snow/encoding.h"

namespace vdisp::snow {

/// Kueblbeck, Ach, Ernst 2005, section 3; names as there.
struct Winnow {
  double theta = 1;      ///< threshold of the activation
  double alpha = 1.05;   ///< promotion, > 1
  double beta = 0.95;    ///< demotion, between 0 and 1
  double initial = 0;    ///< weight of a new link; 0: theta / mean number of active features, so that an untaught target is undecided
  double above = 0;      ///< thick separator, part of theta: positives are promoted up to theta (1 + above)
  double below = 0;      ///< and negatives demoted down to theta (1 - below)
  uint32_t passes = 10;  ///< at most, over all examples; ends before where a pass makes no mistake
  uint32_t seed = 1;     ///< of the order of examples, another one in each pass; 0: as given
  bool operator==(const Winnow&) const = default;
};

/// The weight that a new link gets. `mean_active`: features of an example, on average.
double initial_weight(const Winnow& winnow, double mean_active);

/// One target: a weight for each feature; 0: no link, as none was ever seen with it.
class Target {
 public:
  explicit Target(const Winnow& winnow, double mean_active);

  /// Links features that have none yet.
  void link(std::span<const uint32_t> ids) noexcept;
  /// Equation 3: the sum of weights.
  double activation(std::span<const uint32_t> ids) const noexcept;
  /// Equations 4 and 5. Links; then promotes a positive with activation <= theta (1 + above), demotes a negative with activation
  /// >= theta (1 - below). True: it was a mistake.
  bool learn(std::span<const uint32_t> ids, bool positive) noexcept;
  std::span<const float> weights() const { return weights_; }

 private:
  void scale(std::span<const uint32_t> ids, float factor) noexcept;

  Winnow winnow_;
  float initial_;
  std::vector<float> weights_;
};

/// The sum of weights of those features, in an order that does not depend on the machine.
double activation_of(std::span<const float> weights, std::span<const uint32_t> ids) noexcept;

/// What a target learns from: features of an example are written to `ids`, and whether it is one of the target's class is told.
struct Examples {
  size_t count = 0, most_active = 0;
  std::function<std::span<const uint32_t>(size_t example, std::span<uint32_t> ids)> features;
  std::function<bool(size_t example)> first_class;
  std::function<uint32_t(size_t example)> weight;  ///< times that it is seen in each pass; absent: once
};

/// Called after each pass, with the mistakes of it; false ends the training.
using AfterPass = std::function<bool(uint32_t pass, size_t mistakes)>;

/// Trains the target of the first class, or of the second. The same examples and settings give the same weights.
Target train_target(const Winnow& winnow, const Examples& examples, bool for_first, const AfterPass& after_pass = {});

}  // namespace vdisp::snow
