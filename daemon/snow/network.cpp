// network.cpp: promotion, demotion, passes.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/network.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace vdisp::snow {
namespace {

/// Demoted ever so often, a weight stays a link: 0 would be none.
constexpr float least_weight = 1e-30f, most_weight = 1e30f;

/// The standard leaves std::shuffle to the library; the order must not depend on it.
void shuffle(std::vector<uint32_t>& order, std::mt19937& chance) {
  for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[static_cast<size_t>((uint64_t{chance()} * i) >> 32)]);
}

std::vector<uint32_t> order_of(const Examples& examples) {
  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < examples.count; ++i) order.insert(order.end(), examples.weight ? examples.weight(i) : 1, i);
  return order;
}

double mean_active(const Examples& examples, std::vector<uint32_t>& ids) {
  double sum = 0;
  for (size_t i = 0; i < examples.count; ++i) sum += static_cast<double>(examples.features(i, ids).size());
  return examples.count ? sum / static_cast<double>(examples.count) : 1;
}

}  // namespace

double initial_weight(const Winnow& winnow, double active) {
  return winnow.initial > 0 ? winnow.initial : winnow.theta / std::max(active, 1.0);
}

Target::Target(const Winnow& winnow, double active)
    : winnow_(winnow), initial_(static_cast<float>(initial_weight(winnow, active))), weights_(vector_length) {}

void Target::link(std::span<const uint32_t> ids) noexcept {
  for (const uint32_t id : ids)
    if (weights_[id] == 0) weights_[id] = initial_;
}

double activation_of(std::span<const float> weights, std::span<const uint32_t> ids) noexcept {
  double sums[4] = {};  // four chains of additions, as the processor can have in hand at once
  size_t i = 0;
  for (; i + 4 <= ids.size(); i += 4)
    for (size_t k = 0; k < 4; ++k) sums[k] += weights[ids[i + k]];
  for (; i < ids.size(); ++i) sums[0] += weights[ids[i]];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

double Target::activation(std::span<const uint32_t> ids) const noexcept { return activation_of(weights_, ids); }

void Target::scale(std::span<const uint32_t> ids, float factor) noexcept {
  for (const uint32_t id : ids) weights_[id] = std::clamp(weights_[id] * factor, least_weight, most_weight);
}

bool Target::learn(std::span<const uint32_t> ids, bool positive) noexcept {
  link(ids);
  const double found = activation(ids);
  if (positive && found <= winnow_.theta * (1 + winnow_.above)) {
    scale(ids, static_cast<float>(winnow_.alpha));
    return true;
  }
  if (!positive && found >= winnow_.theta * (1 - winnow_.below)) {
    scale(ids, static_cast<float>(winnow_.beta));
    return true;
  }
  return false;
}

Target train_target(const Winnow& winnow, const Examples& examples, bool for_first, const AfterPass& after_pass) {
  std::vector<uint32_t> ids(examples.most_active), order = order_of(examples);
  Target target(winnow, mean_active(examples, ids));
  std::mt19937 chance(winnow.seed);
  for (uint32_t pass = 0; pass < winnow.passes; ++pass) {
    if (winnow.seed) shuffle(order, chance);
    size_t mistakes = 0;
    for (const uint32_t example : order)
      mistakes += target.learn(examples.features(example, ids), examples.first_class(example) == for_first);
    if (after_pass && !after_pass(pass, mistakes)) break;
    if (mistakes == 0) break;
  }
  return target;
}

}  // namespace vdisp::snow
