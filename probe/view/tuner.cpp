// tuner.cpp: which parameters, and the control socket behind them.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/tuner.h"

#include <algorithm>

namespace vdisp {
namespace {

struct Part {
  std::string_view topics;    // separated by blanks; one that ends with * is a beginning
  std::string_view sections;  // separated by |
};

/// From the stage to what changes it most: its own section, and where it rests on the mounting, that.
constexpr Part parts[] = {
    {"camera/*", "main"},
    {"left right disparity", "image source"},
    {"vdisparity floor floor_model show_floor segments", "Floor|mounting"},
    {"limit show_limit obstacles segment_obstacles height surface standing hanging", "Limit obstacle|Floor"},
    {"map occupancy reason map_changes show_scene", "Limit obstacle|Map|mounting"},
    {"memory tracks fused*", "Memory"},
    {"smooth/* census* depth_map features snow", "snow|census"},
    {"decision drive cross_check", "decide|snow"},
    {"in/*", "control"},
    {"recorder", "recorder"},
};

bool among(std::string_view list, char between, std::string_view word) {
  while (!list.empty()) {
    const std::string_view entry = list.substr(0, list.find(between));
    list.remove_prefix(std::min(entry.size() + 1, list.size()));
    if (entry == word || (entry.ends_with('*') && word.starts_with(entry.substr(0, entry.size() - 1)))) return true;
  }
  return false;
}

}  // namespace

bool concerns(std::string_view topic, std::string_view key) {
  for (const Part& part : parts)
    if (among(part.topics, ' ', topic)) return among(part.sections, '|', key.substr(0, key.rfind('.')));
  return true;
}

void Tuner::open(bool on) {
  panel_.open = on;
  dragging_ = false;
  panel_.trouble.clear();
  if (on) ask();
}

void Tuner::show(std::string_view topic) {
  if (topic == topic_) return;
  topic_ = topic;
  pick();
}

void Tuner::show_all(bool on) {
  everything_ = on;
  pick();
}

void Tuner::ask() {
  if (panel_.waits) return;
  panel_.waits = true;
  talk_.ask({Wish::Kind::all, {}, {}, false});
}

void Tuner::pick() {
  const std::string chosen = panel_.chosen < panel_.sliders.size() ? panel_.sliders[panel_.chosen].info().key : "";
  panel_.sliders.clear();
  panel_.chosen = 0;
  panel_.everything = everything_;
  for (const Slider& slider : all_) {
    if (!everything_ && !concerns(topic_, slider.info().key)) continue;
    if (slider.info().key == chosen) panel_.chosen = panel_.sliders.size();
    panel_.sliders.push_back(slider);
  }
  dragging_ = dragging_ && panel_.chosen < panel_.sliders.size() && panel_.sliders[panel_.chosen].info().key == chosen;
}

void Tuner::choose(int by) {
  const auto count = static_cast<int>(panel_.sliders.size());
  if (count > 0) panel_.chosen = static_cast<size_t>((static_cast<int>(panel_.chosen) + by + count) % count);
}

void Tuner::step(int by) {
  if (panel_.chosen >= panel_.sliders.size()) return;
  Slider& slider = panel_.sliders[panel_.chosen];
  set(slider, slider.moved(by), false);
}

void Tuner::press(size_t index, double place) {
  if (index >= panel_.sliders.size()) return;
  panel_.chosen = index;
  dragging_ = true;
  joined_ = false;
  drag(place);
}

void Tuner::drag(double place) {
  if (!dragging_ || panel_.chosen >= panel_.sliders.size()) return;
  Slider& slider = panel_.sliders[panel_.chosen];
  const std::string value = slider.at(place);
  if (value == slider.info().value) return;
  set(slider, value, joined_);
  joined_ = true;
}

void Tuner::set(Slider& slider, const std::string& value, bool joined) {
  if (value == slider.info().value) return;
  ParameterInfo wanted = slider.info();
  wanted.value = value;
  slider.take(wanted);
  sets_ += talk_.ask({Wish::Kind::set, wanted.key, value, joined});
}

void Tuner::undo() { talk_.ask({Wish::Kind::undo, {}, {}, false}); }

void Tuner::save() { talk_.ask({Wish::Kind::save, {}, {}, false}); }

std::optional<std::string> Tuner::hear() {
  std::optional<std::string> told;
  while (const auto answer = talk_.hear()) {
    std::string line = take(*answer);
    if (!told || !line.empty()) told = std::move(line);
  }
  return told;
}

std::string Tuner::take(const WishAnswer& answer) {
  const bool done = answer.result == Control::Result::done;
  switch (answer.wish.kind) {
    case Wish::Kind::all: take_all(answer); return {};
    case Wish::Kind::set: take_set(answer); return {};
    case Wish::Kind::save: return done ? "written: " + answer.message : answer.message;
    case Wish::Kind::undo: break;
  }
  if (!done) return answer.message;
  ask();
  return "undone: " + (answer.info.help.empty() ? answer.info.key + " = " + answer.info.value : answer.info.help);
}

void Tuner::take_all(const WishAnswer& answer) {
  panel_.waits = false;
  all_.clear();
  panel_.trouble = answer.result == Control::Result::done ? "" : answer.message;
  for (const ParameterInfo& info : answer.all) {
    generation_ = std::max(generation_, info.config_generation);
    if (const auto slider = Slider::of(info); slider && info.key != "Map.angRot") all_.push_back(*slider);
  }
  pick();
}

void Tuner::take_set(const WishAnswer& answer) {
  --sets_;
  const bool done = answer.result == Control::Result::done;
  panel_.trouble = done ? "" : answer.message;
  if (!done) return settle(answer.wish.key);
  generation_ = answer.info.config_generation;
  for (Slider& known : all_) {
    if (known.info().key != answer.info.key) continue;
    ParameterInfo info = answer.info;
    info.help = known.info().help;  // an answer to set has none
    known.take(info);
  }
  if (sets_ == 0) settle();  // before, a slider may be farther than this answer
}

void Tuner::settle(const std::string& key) {
  for (Slider& slider : panel_.sliders)
    for (const Slider& known : all_)
      if (known.info().key == slider.info().key && (key.empty() || known.info().key == key)) slider.take(known.info());
}

void Tuner::follow(uint64_t config_generation) {
  if (!panel_.open || panel_.waits || dragging_ || sets_ > 0 || config_generation <= generation_) return;
  ask();
  generation_ = config_generation;  // where the daemon does not tell, it is not asked again for each image
}

}  // namespace vdisp
