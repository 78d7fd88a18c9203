// classify.cpp: features to numbers, numbers to scores.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/classify.h"

#include <cmath>

#include "daemon/stages/features.h"

namespace vdisp {

std::vector<ImageSpec> Classify::check(std::span<const ImageSpec> in) {
  if (in.size() != 2) throw FormatError("takes features and the left view, was given " + std::to_string(in.size()) + " images");
  const snow::Settings wanted = front_end(config_, in[1]);
  encoding_ = wanted.encoding;
  if (in[0] != snow::feature_spec(encoding_)) throw FormatError("the first input is no image of such features");
  model_.emplace(snow::Model::open(config_.snow.model));
  model_->require(wanted, "[census]");
  ids_.resize(snow::active_features(encoding_));
  return {record_spec<SnowScores>()};
}

Outcome Classify::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  snow::feature_ids(encoding_, *in[0], ids_);
  const auto obstacle = model_->obstacle(ids_), direction = model_->direction(ids_);
  const snow::Trained &of_obstacle = model_->obstacle_training(), &of_direction = model_->direction_training();
  const auto& p = config_.snow;
  SnowScores& scores = make_record<SnowScores>(*out[0]);
  scores.free = obstacle.first;
  scores.obstacle = obstacle.second;
  scores.left = direction.first;
  scores.right = direction.second;
  scores.free_difference = snow::Model::difference(obstacle, of_obstacle);
  scores.left_difference = snow::Model::difference(direction, of_direction);
  scores.obstacle_sensitivity = std::isnan(p.obstacleSensitivity) ? of_obstacle.sensitivity : p.obstacleSensitivity;
  scores.direction_sensitivity = std::isnan(p.directionSensitivity) ? of_direction.sensitivity : p.directionSensitivity;
  scores.clear = of_obstacle.clear * p.clear;
  scores.encoding = static_cast<uint32_t>(encoding_);
  scores.active = static_cast<uint32_t>(ids_.size());
  return Outcome::valid;
}

Way way_of(const SnowScores& scores) noexcept {
  const double over = scores.free_difference + scores.obstacle_sensitivity;
  return {over > 0, scores.left_difference + scores.direction_sensitivity > 0, over > 0 ? std::min(over / scores.clear, 1.0) : 0};
}

}  // namespace vdisp
