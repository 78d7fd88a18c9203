// train.cpp: vdisp-train train: recordings to a model.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/tools/train/report.h"
#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

namespace fs = std::filesystem;

/// Before hours of work: whether the model can be written afterwards.
void require_place(const std::string& path) {
  const fs::path parent = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".";
  std::error_code error;
  if (!fs::is_directory(parent, error)) throw ToolError(EX_CANTCREAT, path + ": there is no folder " + parent.string());
  if (fs::is_directory(path, error)) throw ToolError(EX_CANTCREAT, path + ": is a folder, needed is the name of a file");
  if (access(parent.c_str(), W_OK) != 0) throw ToolError(EX_CANTCREAT, path + ": nothing can be created in " + parent.string());
}

/// What is trained with, and how: said by the command line, or by the model that is added to.
struct Plan {
  std::vector<snow::Source> sources;
  snow::Settings settings;
  snow::Winnow winnow;
  double obstacle_sensitivity = 0, direction_sensitivity = 0;
};

Plan plan_of(const Options& options) {
  Plan plan;
  const bool more = options.folders.empty() && !options.add.empty();
  if (options.folders.empty() && !more)
    throw ToolError(EX_USAGE, "no recording is given; needed are folders, or --add for a model that has a list");
  const std::string base = options.model.empty() ? options.output : options.model;
  if (more) {
    if (!options.config.empty()) throw ToolError(EX_USAGE, "-c is for a new model; --add keeps the front end of " + base);
    const snow::Model model = snow::Model::open(base);
    plan.sources = model.sources();
    plan.settings = model.settings();
    plan.winnow = model.obstacle_training().winnow;
    plan.obstacle_sensitivity = model.obstacle_training().sensitivity;
    plan.direction_sensitivity = model.direction_training().sensitivity;
  }
  plan.obstacle_sensitivity = options.obstacle_sensitivity.value_or(plan.obstacle_sensitivity);
  plan.direction_sensitivity = options.direction_sensitivity.value_or(plan.direction_sensitivity);
  if (!more) plan.settings = census_of(options.config);
  plan.settings = settings_of(options.chosen, plan.settings);
  plan.winnow = winnow_of(options.chosen, plan.winnow);
  for (const snow::Source& source : plan.sources) {
    std::error_code error;
    if (!fs::is_directory(source.folder, error))
      throw ToolError(EX_NOINPUT,
                      base + " was trained with " + source.folder + ", which is not there; give all folders, and --add for the new ones");
  }
  for (auto& source : sources_of(options.folders, 1, false)) plan.sources.push_back(std::move(source));
  for (auto& source : sources_of(options.test, 1, true)) plan.sources.push_back(std::move(source));
  const bool apart = std::any_of(plan.sources.begin(), plan.sources.end(), [](const snow::Source& source) { return source.held_apart; });
  if (!apart && options.hold_out > 0 && !more) hold_out(plan.sources, worlds_of(plan.sources), options.hold_out, options.split_seed);
  for (auto& source : sources_of(options.add, options.add_weight, false)) plan.sources.push_back(std::move(source));
  return plan;
}

/// Those of the chosen encoding first.
std::vector<Job> jobs_of(const Plan& plan, bool compare) {
  std::vector<Job> jobs{{plan.settings.encoding, plan.winnow}};
  for (const snow::Encoding encoding : snow::encodings)
    if (compare && encoding != plan.settings.encoding) jobs.push_back({encoding, plan.winnow});
  return jobs;
}

Judged judged(const Drives& drives, const FeatureTable& table, const Job& job, Classifiers& found, const Plan& plan,
              const Options& options) {
  double free = plan.obstacle_sensitivity;
  const Judgement judgement = judge(drives, table, job.encoding, found, options.threads);
  if (const auto curve = snow::roc_curve(judgement.obstacle); options.detection && !curve.empty())
    free = obstacle_sensitivity_of(snow::point_of_detection(curve, *options.detection));
  Judged result{std::string(name(job.encoding)), obstacle_verdict(judgement, free),
                direction_verdict(judgement, plan.direction_sensitivity)};
  found.obstacle.trained.clear = clear_of(judgement);
  found.obstacle.trained.sensitivity = free, found.direction.trained.sensitivity = plan.direction_sensitivity;
  found.obstacle.trained.auc = result.obstacle.auc, found.direction.trained.auc = result.direction.auc;
  return result;
}

std::string text_of(const Drives& drives, const FeatureTable& table) {
  const Classes with = drives.classes(false), apart = drives.classes(true);
  std::string text;
  for (const auto& [what, classes, count] :
       {std::tuple{"trained with", with, drives.count(false)}, {"held apart", apart, drives.count(true)}})
    text += std::string(what) + ": " + counted(count, "drive") + ", " + std::to_string(classes.forward) + " pairs forward, " +
            std::to_string(classes.left) + " left, " + std::to_string(classes.right) + " right\n";
  if (drives.unlabelled) text += "left out: " + std::to_string(drives.unlabelled) + " pairs without label\n";
  if (const size_t blind = table.blind_count()) {
    const size_t apart_blind = apart.all() - table.classes(drives, true).all();
    text += "left out: " + std::to_string(blind) + " pairs with which the daemon would be blind";
    text += (apart_blind ? ", " + std::to_string(apart_blind) + " of them held apart" : "") + "\n";
  }
  if (drives.cut_off) text += "left out: " + std::to_string(drives.cut_off) + " pairs or lines that were cut off\n";
  return text;
}

nlohmann::json json_of(const Drives& drives, const FeatureTable& table) {
  nlohmann::json json;
  for (const bool apart : {false, true}) {
    const Classes classes = drives.classes(apart);
    json[apart ? "held_apart" : "trained_with"] = {{"drives", drives.count(apart)},
                                                   {"forward", classes.forward},
                                                   {"left", classes.left},
                                                   {"right", classes.right},
                                                   {"blind", classes.all() - table.classes(drives, apart).all()}};
  }
  json["unlabelled"] = drives.unlabelled;
  json["blind"] = table.blind_count();
  return json;
}

/// What the daemon's configuration has to say for this model, where that is not the default.
std::string keys_of(const snow::Settings& settings) {
  static constexpr const char* smooths[] = {"none", "mean", "median"};
  std::ostringstream text;
  text << "for vdisp.cfg: [census] encoding = " << name(settings.encoding) << ", smooth = " << smooths[static_cast<size_t>(settings.smooth)]
       << ", block = " << settings.block << ", width = " << settings.disparities << ", confidence = " << settings.confidence
       << "; scale so that views are " << settings.width << "x" << settings.height << "\n";
  return text.str();
}

void tell(const Options& options, const Plan& plan, const Drives& drives, const FeatureTable& table, const std::vector<Judged>& all) {
  if (options.json) {
    nlohmann::json json = json_of(drives, table);
    json["model"] = options.output;
    for (const Judged& one : all) {
      json["encodings"][one.encoding] = {{"obstacle", json_of(one.obstacle)}, {"direction", json_of(one.direction)}};
    }
    json["encoding"] = all.front().encoding;
    std::cout << json.dump(2) << '\n';
    return;
  }
  std::cout << text_of(drives, table);
  for (const Judged& one : all)
    if (drives.count(true)) std::cout << "\n" << one.encoding << "\n" << text_of(one.obstacle) << text_of(one.direction);
  if (options.detection) std::cout << "\nThe obstacle sensitivity was chosen on the pairs held apart: of others it finds about as many.\n";
  std::cout << "\nmodel: " << options.output << "\n" << keys_of(plan.settings);
}

}  // namespace

int train(const Options& options) {
  require_place(options.output);
  const Plan plan = plan_of(options);
  const Drives drives = open_drives(plan.sources);
  drives.require_classes(false, options.obstacle_only);
  if (drives.count(true))
    drives.require_classes(true, options.obstacle_only);
  else if (options.compare || options.detection || !options.plots.empty())
    throw ToolError(EX_USAGE, "--compare, --detection and --plots need recordings held apart; give --test DIR or --hold-out");
  const auto jobs = jobs_of(plan, options.compare);
  std::vector<snow::Encoding> encodings;
  for (const Job& job : jobs) encodings.push_back(job.encoding);
  const FeatureTable table(drives, plan.settings, encodings, options.threads);
  table.require_classes(drives, false, options.obstacle_only);
  if (drives.count(true)) table.require_classes(drives, true, options.obstacle_only);

  std::vector<Judged> all(jobs.size());
  std::optional<Classifiers> chosen;
  train_all(drives, table, jobs, options.obstacle_only, options.threads, [&](size_t job, Classifiers&& found) {
    all[job] = judged(drives, table, jobs[job], found, plan, options);
    if (job == 0) chosen.emplace(std::move(found));
  });
  save(options.output, plan.settings, *chosen, drives);
  if (!options.plots.empty() && drives.count(true)) write_plots(options.plots, all);
  tell(options, plan, drives, table, all);
  return EX_OK;
}

}  // namespace vdisp::train
