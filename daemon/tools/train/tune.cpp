// tune.cpp: vdisp-train tune: which front end, encoding, separator and sensitivity separate best.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>

#include "daemon/tools/train/report.h"
#include "daemon/tools/train/trials.h"
#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

/// All front ends of the grid, in an order by chance, so that a search that is cut short has seen something of everything.
std::vector<snow::Settings> front_ends(const Options& options) {
  std::vector<snow::Settings> all;
  const Grid& grid = options.grid;
  for (const std::string& smooth : grid.smooths)
    for (const uint32_t block : grid.blocks)
      for (const uint32_t width : grid.widths)
        for (const double confidence : grid.confidences) {
          Chosen chosen = options.chosen;
          chosen.smooth = smooth, chosen.block = block, chosen.disparities = width, chosen.confidence = confidence;
          all.push_back(settings_of(chosen, census_of("")));
        }
  std::mt19937 chance(options.split_seed);
  for (size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[static_cast<size_t>((uint64_t{chance()} * i) >> 32)]);
  if (grid.trials && grid.trials < all.size()) all.resize(grid.trials);
  return all;
}

/// Encodings and separators to be tried with one front end, those that the table has left out.
std::vector<Trial> trials_of(const snow::Settings& settings, const Grid& grid, const TrialTable& table) {
  std::vector<Trial> trials;
  for (const std::string& encoding : grid.encodings)
    for (const double thick : grid.thick) {
      Trial trial;
      trial.settings = settings;
      trial.settings.encoding = *snow::encoding_named(encoding);
      trial.thick = thick;
      if (!table.has(trial)) trials.push_back(trial);
    }
  return trials;
}

void judge_trial(Trial& trial, const Drives& drives, const FeatureTable& table, const Classifiers& found, int threads) {
  const Judgement judgement = judge(drives, table, trial.settings.encoding, found, threads);
  trial.obstacle_auc = snow::area_under_curve(judgement.obstacle);
  trial.direction_auc = snow::area_under_curve(judgement.direction);
  trial.obstacle_sensitivity = obstacle_sensitivity_of(snow::best_point(snow::roc_curve(judgement.obstacle)));
  trial.direction_sensitivity = direction_sensitivity_of(snow::best_point(snow::roc_curve(judgement.direction)));
}

void try_front_end(std::vector<Trial>& trials, const Drives& drives, const snow::Winnow& winnow, int threads, TrialTable& table) {
  std::vector<snow::Encoding> encodings;
  std::vector<Job> jobs;
  for (const Trial& trial : trials) {
    if (std::find(encodings.begin(), encodings.end(), trial.settings.encoding) == encodings.end())
      encodings.push_back(trial.settings.encoding);
    jobs.push_back({trial.settings.encoding, winnow});
    jobs.back().winnow.above = jobs.back().winnow.below = trial.thick;
  }
  const FeatureTable features(drives, trials.front().settings, encodings, threads);
  for (const bool apart : {false, true})
    if (!features.classes(drives, apart).missing().empty())
      throw ToolError(
          EX_NOINPUT,
          "with this front end the daemon would be blind with every pair of a class; more light, or a lower confidence is needed");
  train_all(drives, features, jobs, false, threads, [&](size_t job, Classifiers&& found) {
    judge_trial(trials[job], drives, features, found, threads);
    table.add(trials[job]);
  });
}

/// What all trials of a table have in common; two tables with the same are one.
std::string question_of(const Drives& drives, const snow::Winnow& winnow, const Options& options) {
  const Classes with = drives.classes(false), apart = drives.classes(true);
  uint64_t hash = 14695981039346656037u;  // FNV-1a of all names and what is held apart
  for (const snow::Source& source : drives.sources)
    for (const char c : source.folder + (source.held_apart ? "|1|" : "|0|") + std::to_string(source.weight))
      hash = (hash ^ static_cast<uint8_t>(c)) * 1099511628211u;
  std::ostringstream text;
  text << "vdisp-train tune: " << drives.count(false) << "+" << drives.count(true) << " recordings " << std::hex << hash << std::dec
       << ", pairs " << with.forward << "/" << with.left << "/" << with.right << "+" << apart.forward << "/" << apart.left << "/"
       << apart.right << ", split " << options.split_seed << ", theta " << winnow.theta << " alpha " << winnow.alpha << " beta "
       << winnow.beta << " initial " << winnow.initial << " passes " << winnow.passes << " seed " << winnow.seed;
  return text.str();
}

Drives drives_of(const Options& options) {
  auto sources = sources_of(options.folders, 1, false);
  if (options.test.empty()) {
    // What train would judge on with the same --hold-out has no say in what is chosen; what is chosen by is a part of the rest.
    hold_out(sources, worlds_of(sources), options.hold_out, options.split_seed);
    std::erase_if(sources, [](const snow::Source& source) { return source.held_apart; });
    hold_out(sources, worlds_of(sources), options.hold_out, options.split_seed);
  }
  for (auto& source : sources_of(options.test, 1, true)) sources.push_back(std::move(source));
  Drives drives = open_drives(std::move(sources));
  drives.thin(options.grid.pairs);
  for (const bool apart : {false, true}) drives.require_classes(apart);
  return drives;
}

void tell(const TrialTable& table, bool as_json) {
  if (!as_json) {
    std::cout << text_of(table.trials());
    return;
  }
  nlohmann::json json = nlohmann::json::array();
  for (const Trial& t : table.trials())
    json.push_back({{"encoding", name(t.settings.encoding)},
                    {"width", t.settings.disparities},
                    {"block", t.settings.block},
                    {"smooth", t.settings.smooth == snow::Smooth::none   ? "none"
                               : t.settings.smooth == snow::Smooth::mean ? "mean"
                                                                         : "median"},
                    {"confidence", t.settings.confidence},
                    {"thick", t.thick},
                    {"obstacle_auc", t.obstacle_auc},
                    {"direction_auc", t.direction_auc},
                    {"obstacle_sensitivity", t.obstacle_sensitivity},
                    {"direction_sensitivity", t.direction_sensitivity}});
  std::cout << json.dump(2) << '\n';
}

}  // namespace

int tune(const Options& options) {
  const snow::Winnow winnow = winnow_of(options.chosen);
  const auto settings = front_ends(options);
  const Drives drives = drives_of(options);
  TrialTable table(options.grid.table, question_of(drives, winnow, options));
  for (size_t i = 0; i < settings.size(); ++i) {
    auto trials = trials_of(settings[i], options.grid, table);
    if (trials.empty()) continue;
    std::cerr << "vdisp-train: front end " << i + 1 << " of " << settings.size() << std::endl;
    try_front_end(trials, drives, winnow, options.threads, table);
  }
  tell(table, options.json);
  return EX_OK;
}

}  // namespace vdisp::train
