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
    if (held_apart(sample) == apart)
      ++(sample.label == Label::forward ? found.forward : sample.label == Label::left ? found.left : found.right);
  return found;
}

void Drives::require_classes(bool apart, bool obstacle_only) const {
  const Classes found = classes(apart);
  if (found.missing().empty() || (obstacle_only && found.forward && found.left + found.right)) return;
  const std::string what = found.all() == 0 ? "no labelled pair" : "no pair with label " + found.missing();
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

void hold_out(std::vector<snow::Source>& sources, double part, uint32_t seed) {
  std::vector<size_t> order;
  for (size_t i = 0; i < sources.size(); ++i)
    if (sources[i].weight == 1 && !sources[i].held_apart) order.push_back(i);
  const size_t apart = std::max<size_t>(1, static_cast<size_t>(std::lround(part * static_cast<double>(order.size()))));
  if (apart >= order.size())
    throw ToolError(EX_NOINPUT, counted(order.size(), "recording") + ", of which " + std::to_string(apart) +
                                    " would be held apart and none remain to train with; needed are more, --test DIR, or --hold-out 0");
  std::mt19937 chance(seed);
  for (size_t i = 0; i < apart; ++i) {  // the first places of a shuffle that does not depend on the library
    const size_t other = i + static_cast<size_t>((uint64_t{chance()} * (order.size() - i)) >> 32);
    std::swap(order[i], order[other]);
    sources[order[i]].held_apart = true;
  }
}

}  // namespace vdisp::train
