// evaluate.cpp: vdisp-train evaluate: a model against recordings that it has not seen.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "daemon/tools/train/report.h"
#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

/// Of the simulator; empty also where the recording is not there any more.
std::string world_if_there(const std::string& folder) {
  try {
    return world_of(folder);
  } catch (const RecordingError&) {
    return "";
  }
}

/// Judging on what was trained with says nothing.
void require_unseen(const snow::Model& model, const std::vector<snow::Source>& sources, const std::string& name) {
  const auto refuse = [&](const snow::Source& mine, const std::string& what) {
    throw ToolError(EX_USAGE, mine.folder + ": " + name + " was trained with " + what + "; needed are recordings that were held apart");
  };
  std::map<std::string, std::string> worlds;  // that were trained with, and where
  for (const snow::Source& seen : model.sources())
    if (!seen.held_apart) worlds.emplace(world_if_there(seen.folder), seen.folder);
  for (const snow::Source& mine : sources) {
    for (const snow::Source& seen : model.sources())
      if (!seen.held_apart && seen.folder == mine.folder) refuse(mine, "it");
    const std::string world = world_of(mine.folder);
    if (const auto same = worlds.find(world); !world.empty() && same != worlds.end())
      refuse(mine, same->second + ", which is of the same world (" + world + ")");
  }
}

}  // namespace

int evaluate(const Options& options) {
  const snow::Model model = snow::Model::open(options.model);
  const auto sources = sources_of(options.folders, 1, true);
  require_unseen(model, sources, options.model);
  const Drives drives = open_drives(sources);
  const Classes classes = drives.classes(true);
  if (classes.all() == 0)
    throw ToolError(EX_NOINPUT, "no labelled pair in the " + counted(sources.size(), "recording") + "; there is nothing to judge on");
  if (!classes.forward && (!classes.left || !classes.right))
    throw ToolError(EX_NOINPUT,
                    "no pair with label " + classes.missing() + " in the recordings; needed are two of forward, left and right");
  if (classes.forward == classes.all())
    throw ToolError(EX_NOINPUT, "no pair with label left and right in the recordings; needed is one at least, and forward");

  const snow::Encoding encoding = model.settings().encoding;
  const FeatureTable table(drives, model.settings(), std::span(&encoding, 1), options.threads);
  if (table.numbers(drives, true).empty())
    throw ToolError(EX_NOINPUT, "the daemon would be blind with every labelled pair; there is nothing to judge on");
  const Judgement judgement = judge(drives, table, model, options.threads);
  const Judged found{std::string(name(encoding)), obstacle_verdict(judgement, model.obstacle_training().sensitivity),
                     direction_verdict(judgement, model.direction_training().sensitivity)};
  if (!options.plots.empty()) write_plots(options.plots, {found});
  if (options.json) {
    const nlohmann::json json{
        {"model", options.model},
        {"encoding", found.encoding},
        {"held_apart", {{"drives", sources.size()}, {"forward", classes.forward}, {"left", classes.left}, {"right", classes.right}}},
        {"obstacle", json_of(found.obstacle)},
        {"direction", json_of(found.direction)}};
    std::cout << json.dump(2) << '\n';
  } else {
    std::cout << found.encoding << "\n" << text_of(found.obstacle) << text_of(found.direction);
  }
  return EX_OK;
}

}  // namespace vdisp::train
