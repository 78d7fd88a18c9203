// drives.cpp: opens recordings, splits them by whole drives.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/drives.h"

#include <sysexits.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

namespace fs = std::filesystem;

void add_samples(Drives& drives, uint32_t drive) {
  const auto& pairs = drives.recordings[drive].pairs();
  for (uint32_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].label == Label::none)
      ++drives.unlabelled;
    else
      drives.samples.push_back({drive, i, pairs[i].label});
  }
}

std::string world_in(const RecordingInfo& info) { return info.world.empty() ? "" : info.world + ", seed " + std::to_string(info.seed); }

}  // namespace

std::string Classes::missing() const {
  std::string text;
  for (const auto& [count, name] : {std::pair{forward, "forward"}, {left, "left"}, {right, "right"}})
    if (!count) text += (text.empty() ? "" : " and ") + std::string(name);
  return text;
}

Classes Drives::classes(bool apart) const {
  Classes found;
  for (const Sample& sample : samples)
    if (held_apart(sample) == apart) found.add(sample.label);
  return found;
}

void Drives::require(const Classes& found, bool apart, bool obstacle_only, const std::string& which) const {
  if (found.missing().empty() || (obstacle_only && found.forward && found.left + found.right)) return;
  const std::string what = (found.all() == 0 ? "no labelled pair" : "no pair with label " + found.missing()) + which;
  throw ToolError(EX_NOINPUT, what + " in the " + counted(count(apart), "recording") +
                                  (apart ? " held apart to judge on" : " to train with") + "; needed are forward, left and right" +
                                  (apart ? ": give others with --test, or another --hold-out or --split-seed" : ""));
}

size_t Drives::count(bool apart) const {
  return static_cast<size_t>(
      std::count_if(sources.begin(), sources.end(), [apart](const snow::Source& source) { return source.held_apart == apart; }));
}

std::vector<uint32_t> Drives::numbers(bool apart) const {
  std::vector<uint32_t> found;
  for (uint32_t i = 0; i < samples.size(); ++i)
    if (held_apart(samples[i]) == apart) found.push_back(i);
  return found;
}

void Drives::thin(size_t most) {
  if (samples.size() <= most) return;
  std::vector<Sample> kept;
  // Over all samples in order: each recording keeps its part, and what it keeps lies evenly in it.
  for (size_t i = 0; i < samples.size(); ++i)
    if ((i + 1) * most / samples.size() != i * most / samples.size()) kept.push_back(samples[i]);
  samples = std::move(kept);
}

namespace {

/// Who was trained in a world knows it: drives of it on both sides are one drive on both sides.
void require_worlds_apart(const Drives& drives) {
  std::map<std::string, size_t> trained;
  for (size_t i = 0; i < drives.sources.size(); ++i)
    if (!drives.sources[i].held_apart) trained.emplace(world_in(drives.recordings[i].info()), i);
  for (size_t i = 0; i < drives.sources.size(); ++i) {
    const std::string world = world_in(drives.recordings[i].info());
    const auto same = drives.sources[i].held_apart && !world.empty() ? trained.find(world) : trained.end();
    if (same != trained.end())
      throw ToolError(EX_USAGE, drives.sources[i].folder + " is held apart to judge on, " + drives.sources[same->second].folder +
                                    " is trained with, and both are of one world (" + world + "); give them both to the same side");
  }
}

}  // namespace

std::string world_of(const std::string& folder) { return world_in(Recording::info_of(folder)); }

std::vector<std::string> worlds_of(std::span<const snow::Source> sources) {
  std::vector<std::string> worlds;
  for (const snow::Source& source : sources) worlds.push_back(world_of(source.folder));
  return worlds;
}

Drives open_drives(std::vector<snow::Source> sources) {
  Drives drives;
  std::map<fs::path, std::string> seen;
  for (const snow::Source& source : sources) {
    std::error_code ignored;
    const auto [place, fresh] = seen.emplace(fs::weakly_canonical(source.folder, ignored), source.folder);
    if (!fresh) throw ToolError(EX_USAGE, source.folder + " is given twice; a drive is trained with or judged on, once");
  }
  for (const snow::Source& source : sources) {
    drives.recordings.emplace_back(source.folder);
    drives.cut_off += drives.recordings.back().cut_off();
    drives.sources.push_back(source);
    add_samples(drives, static_cast<uint32_t>(drives.recordings.size() - 1));
  }
  require_worlds_apart(drives);
  return drives;
}

std::vector<snow::Source> sources_of(std::span<const std::string> folders, uint32_t weight, bool held_apart) {
  std::vector<snow::Source> sources;
  for (const std::string& folder : folders) {
    std::error_code error;
    const fs::path path = fs::canonical(folder, error);
    if (error || !fs::is_directory(path)) throw ToolError(EX_NOINPUT, folder + ": no such folder; needed is a labelled recording");
    sources.push_back({path.string(), weight, held_apart});
  }
  return sources;
}

void hold_out(std::vector<snow::Source>& sources, std::span<const std::string> worlds, double part, uint32_t seed) {
  std::vector<size_t> order;
  for (size_t i = 0; i < sources.size(); ++i)
    if (sources[i].weight == 1 && !sources[i].held_apart) order.push_back(i);
  const size_t apart = std::max<size_t>(1, static_cast<size_t>(std::lround(part * static_cast<double>(order.size()))));
  if (apart >= order.size())
    throw ToolError(EX_NOINPUT, counted(order.size(), "recording") + ", of which " + std::to_string(apart) +
                                    " would be held apart and none remain to train with; needed are more, --test DIR, or --hold-out 0");
  std::mt19937 chance(seed);
  size_t held = 0;
  for (size_t i = 0; held < apart; ++i) {  // the first places of a shuffle that does not depend on the library
    const size_t other = i + static_cast<size_t>((uint64_t{chance()} * (order.size() - i)) >> 32);
    std::swap(order[i], order[other]);
    for (const size_t j : order) {
      const bool together = j == order[i] || (!worlds[j].empty() && worlds[j] == worlds[order[i]]);
      if (together && !sources[j].held_apart) sources[j].held_apart = true, ++held;
    }
  }
  if (held == order.size())
    throw ToolError(EX_NOINPUT, "all " + counted(held, "recording") + " are of one world (" + worlds[order[0]] +
                                    ") and none remain to train with; needed are others, --test DIR, or --hold-out 0");
}

}  // namespace vdisp::train
