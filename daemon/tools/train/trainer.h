// trainer.h: both classifiers from samples that are trained with, and what they say of those held apart.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "daemon/snow/model.h"
#include "daemon/snow/roc.h"
#include "daemon/tools/train/feature_table.h"

namespace vdisp::train {

/// Two targets that were trained against each other's class.
struct Classifier {
  snow::Target first, second;
  snow::Trained trained;
};
struct Classifiers {
  Classifier obstacle;   ///< first = free, second = obstacle
  Classifier direction;  ///< first = left, second = right
};

/// What is trained: an encoding of the table with a network's parameters.
struct Job {
  snow::Encoding encoding;
  snow::Winnow winnow;
};

/// Trains all jobs on the samples not held apart, their four targets each shared by `threads`. `done` gets each job's classifiers as
/// soon as they are there, one call at a time, in no certain order. Results do not depend on the number of threads. `obstacle_only`: the
/// direction classifier learns nothing, has no weights and always says right.
void train_all(const Drives& drives, const FeatureTable& table, std::span<const Job> jobs, bool obstacle_only, int threads,
               const std::function<void(size_t job, Classifiers&&)>& done);

/// Both scores of each held apart sample (or of all that were trained with), over theta. Positives: obstacle (score = obstacle -
/// free), and left (score = left - right, of samples with obstacle only).
struct Judgement {
  std::vector<snow::Judged> obstacle, direction;
};
/// differences(sample): first - second of both classifiers, over theta.
struct Differences {
  double free, left;
};
Judgement judge(const Drives& drives, std::span<const uint32_t> samples, int threads,
                const std::function<Differences(uint32_t sample, std::span<uint32_t> ids)>& differences);
Judgement judge(const Drives& drives, const FeatureTable& table, snow::Encoding encoding, const Classifiers& classifiers, int threads);
Judgement judge(const Drives& drives, const FeatureTable& table, const snow::Model& model, int threads);

/// The model's file. Sensitivities and AUC are in `trained` of the classifiers.
void save(const std::string& path, const snow::Settings& settings, const Classifiers& classifiers, const Drives& drives);

}  // namespace vdisp::train
