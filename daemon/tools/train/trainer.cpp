// trainer.cpp: four targets a job, each a task of its own.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/trainer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "daemon/tools/train/parallel.h"
#include "daemon/tools/train/progress.h"

namespace vdisp::train {
namespace {

/// What one of the two classifiers learns from.
struct Lesson {
  std::vector<uint32_t> samples;
  Label first;
  uint64_t count[2] = {};  // of first and second
};

Lesson lesson_of(const Drives& drives, const FeatureTable& table, bool direction) {
  Lesson lesson{{}, direction ? Label::left : Label::forward};
  for (const uint32_t sample : table.numbers(drives, false)) {
    const Label label = drives.samples[sample].label;
    if (direction && label == Label::forward) continue;
    lesson.samples.push_back(sample);
    ++lesson.count[label != lesson.first];
  }
  return lesson;
}

snow::Examples examples_of(const Drives& drives, const FeatureTable& table, snow::Encoding encoding, const Lesson& lesson) {
  snow::Examples examples;
  examples.count = lesson.samples.size();
  examples.most_active = snow::active_features(encoding);
  examples.features = [&table, &lesson, encoding](size_t i, std::span<uint32_t> ids) {
    return table.ids(encoding, lesson.samples[i], ids);
  };
  examples.first_class = [&drives, &lesson](size_t i) { return drives.samples[lesson.samples[i]].label == lesson.first; };
  examples.weight = [&drives, &lesson](size_t i) { return drives.sources[drives.samples[lesson.samples[i]].drive].weight; };
  return examples;
}

/// The targets of a job as they are done.
struct Unfinished {
  std::array<std::optional<snow::Target>, 4> targets;
  std::array<uint32_t, 4> passes{};
  int left = 4;
};

Classifier classifier_of(Unfinished& job, size_t at, const snow::Winnow& winnow, const Lesson& lesson, snow::Encoding encoding) {
  snow::Trained trained;
  trained.winnow = winnow;
  trained.initial = snow::initial_weight(winnow, static_cast<double>(snow::active_features(encoding)));
  trained.auc = std::nan("");
  trained.first = lesson.count[0], trained.second = lesson.count[1];
  trained.passes[0] = job.passes[at], trained.passes[1] = job.passes[at + 1];
  return {std::move(*job.targets[at]), std::move(*job.targets[at + 1]), trained};
}

}  // namespace

void train_all(const Drives& drives, const FeatureTable& table, std::span<const Job> jobs, bool obstacle_only, int threads,
               const std::function<void(size_t, Classifiers&&)>& done) {
  const Lesson lessons[] = {lesson_of(drives, table, false), obstacle_only ? Lesson{{}, Label::left} : lesson_of(drives, table, true)};
  std::vector<Unfinished> unfinished(jobs.size());
  std::mutex finishing;
  size_t passes = 0;
  for (const Job& job : jobs) passes += 2 * job.winnow.passes * (lessons[0].samples.size() + lessons[1].samples.size());
  Progress progress("training", passes);
  in_parallel(threads, 4 * jobs.size(), [&](size_t task, int) {
    const size_t number = task / 4, at = task % 4;
    const Job& job = jobs[number];
    const Lesson& lesson = lessons[at / 2];
    uint32_t ran = 0;
    snow::Target target = train_target(job.winnow, examples_of(drives, table, job.encoding, lesson), at % 2 == 0, [&](uint32_t, size_t) {
      ++ran;
      progress.add(lesson.samples.size());
      return true;
    });
    progress.add((job.winnow.passes - ran) * lesson.samples.size());
    const std::lock_guard lock(finishing);
    Unfinished& mine = unfinished[number];
    mine.targets[at].emplace(std::move(target));
    mine.passes[at] = ran;
    if (--mine.left > 0) return;
    done(number,
         {classifier_of(mine, 0, job.winnow, lessons[0], job.encoding), classifier_of(mine, 2, job.winnow, lessons[1], job.encoding)});
  });
}

Judgement judge(const Drives& drives, std::span<const uint32_t> samples, int threads,
                const std::function<Differences(uint32_t, std::span<uint32_t>)>& differences) {
  std::vector<Differences> found(samples.size());
  std::vector<std::vector<uint32_t>> ids(static_cast<size_t>(threads), std::vector<uint32_t>(snow::columns * snow::rows));
  in_parallel(threads, samples.size(), [&](size_t i, int seat) { found[i] = differences(samples[i], ids[static_cast<size_t>(seat)]); });
  Judgement judgement;
  for (size_t i = 0; i < samples.size(); ++i) {
    const Label label = drives.samples[samples[i]].label;
    judgement.obstacle.push_back({-found[i].free, label != Label::forward});
    if (label != Label::forward) judgement.direction.push_back({found[i].left, label == Label::left});
  }
  return judgement;
}

Judgement judge(const Drives& drives, const FeatureTable& table, snow::Encoding encoding, const Classifiers& classifiers, int threads) {
  const auto difference = [](const Classifier& c, std::span<const uint32_t> ids) {
    return (c.first.activation(ids) - c.second.activation(ids)) / c.trained.winnow.theta;
  };
  return judge(drives, table.numbers(drives, true), threads, [&](uint32_t sample, std::span<uint32_t> space) {
    const auto ids = table.ids(encoding, sample, space);
    return Differences{difference(classifiers.obstacle, ids), difference(classifiers.direction, ids)};
  });
}

Judgement judge(const Drives& drives, const FeatureTable& table, const snow::Model& model, int threads) {
  return judge(drives, table.numbers(drives, true), threads, [&](uint32_t sample, std::span<uint32_t> space) {
    const auto ids = table.ids(model.settings().encoding, sample, space);
    return Differences{snow::Model::difference(model.obstacle(ids), model.obstacle_training()),
                       snow::Model::difference(model.direction(ids), model.direction_training())};
  });
}

void save(const std::string& path, const snow::Settings& settings, const Classifiers& classifiers, const Drives& drives) {
  snow::ModelParts parts;
  parts.settings = settings;
  parts.obstacle = classifiers.obstacle.trained;
  parts.direction = classifiers.direction.trained;
  parts.free = classifiers.obstacle.first.weights(), parts.obstacles = classifiers.obstacle.second.weights();
  parts.left = classifiers.direction.first.weights(), parts.right = classifiers.direction.second.weights();
  parts.sources = drives.sources;
  snow::write_model(path, parts);
}

}  // namespace vdisp::train
