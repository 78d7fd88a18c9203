// driver.cpp: the schedule is the order of add(); an image is published when its last reader has run, the map at once.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/driver.h"

#include <algorithm>

#include "daemon/core/clock.h"
#include "daemon/core/driver_parts.h"

namespace vdisp {

Driver::Driver(uint64_t epoch) : epoch_(epoch) {}
Driver::~Driver() = default;

namespace {
std::string words(const ImageSpec& spec) {
  return std::string(name(spec.pixel)) + " " + std::to_string(spec.width) + "x" + std::to_string(spec.height);
}
}  // namespace

const std::string& Driver::name_of(Handle input) const { return input.last < 0 ? topics_[input.topic].name : delayed_[input.last].name; }
const ImageSpec& Driver::spec_of(Handle input) const { return input.last < 0 ? topics_[input.topic].spec : delayed_[input.last].spec; }

std::string Driver::label(const Stage& stage) const {
  std::string text;
  for (Handle input : stage.inputs)
    text += (text.empty() ? " of " : ", ") + std::string(input.last < 0 ? "'" : "the last '") + name_of(input) + "' (" +
            words(spec_of(input)) + ")";
  return text;
}

Handle Driver::last(const std::string& name, const ImageSpec& spec) {
  delayed_.push_back({name, spec, -1, nullptr});
  return {-1, static_cast<int>(delayed_.size()) - 1};
}

std::vector<Handle> Driver::add_set(std::vector<std::string> names, std::unique_ptr<ImageProcessor> processor, std::vector<Handle> inputs,
                                    Need need) {
  Stage stage;
  stage.need = need;
  std::vector<ImageSpec> in;
  for (Handle input : inputs) {
    const bool known = input.last < 0 ? input.topic >= 0 && input.topic < static_cast<int>(topics_.size())
                                      : input.last < static_cast<int>(delayed_.size());
    if (!known) throw FormatError("stage '" + names.at(0) + "': an input does not exist yet; stages are added after their inputs");
    const bool source = dynamic_cast<const ImageSource*>(processor.get()) != nullptr;
    if (source && input.last < 0)
      throw FormatError("stage '" + names.at(0) + "': a source, its input '" + name_of(input) +
                        "' is of this frame; needed is one of the last: the source begins the frame");
    if (stage.inputs.empty() && input.last >= 0 && !source)
      throw FormatError("stage '" + names.at(0) + "': its first input is the last '" + name_of(input) +
                        "', needed is one of this frame: it gives frame and time");
    stage.inputs.push_back(input);
    in.push_back(spec_of(input));
  }
  for (const std::string& topic : names) {
    const bool taken = std::any_of(topics_.begin(), topics_.end(), [&](const Topic& t) { return t.name == topic; });
    if (taken || topic == "catalogue" || topic == "health" || topic == "heartbeat")
      throw FormatError("stage '" + topic + "': the name is taken; each topic has one");
  }
  std::vector<ImageSpec> out;
  try {
    out = processor->check(in);
  } catch (const FormatError& error) {
    throw FormatError("stage '" + names.at(0) + "'" + label(stage) + ": " + error.what());
  }
  if (out.size() != names.size())
    throw FormatError("stage '" + names.at(0) + "' makes " + std::to_string(out.size()) + " images, was given " +
                      std::to_string(names.size()) + " names");

  // Nothing below throws FormatError: a refused stage leaves no trace in the tree.
  const int index = static_cast<int>(stages_.size());
  std::vector<Handle> handles;
  for (size_t i = 0; i < names.size(); ++i) {
    handles.push_back({static_cast<int>(topics_.size())});
    stage.outputs.push_back(handles.back().topic);
    topics_.push_back({names[i], out[i], inputs, index});
    slots_.emplace_back();
  }
  stage.in.resize(stage.inputs.size());
  stage.out.resize(stage.outputs.size());
  stage.processor = std::move(processor);
  stages_.push_back(std::move(stage));
  return handles;
}

Handle Driver::add(const std::string& name, std::unique_ptr<ImageProcessor> stage, std::vector<Handle> inputs, Need need) {
  return add_set({name}, std::move(stage), std::move(inputs), need).at(0);
}

void Driver::connect(const OutletFactory& outlet) {
  for (Stage& stage : stages_) {
    for (size_t i = 0; i < stage.inputs.size(); ++i) {
      Handle& input = stage.inputs[i];
      if (input.last >= 0) input.topic = find_delayed(topics_[stage.outputs[0]].name, delayed_[input.last]);
      for (int output : stage.outputs) topics_[output].parents[i] = input;
    }
  }
  for (size_t i = 0; i < topics_.size(); ++i) slots_[i].outlet = outlet(topics_[i].name, topics_[i].spec);
  catalogue_ = outlet("catalogue", record_spec<Catalogue>());
  health_ = outlet("health", record_spec<Health>());
  heartbeat_ = outlet("heartbeat", record_spec<Heartbeat>());
  began_ns_ = monotonic_ns();
}

/// Its topic. `reader`: the stage that reads it.
int Driver::find_delayed(const std::string& reader, Delayed& delayed) {
  const std::string who = "stage '" + reader + "' reads the last '" + delayed.name + "'";
  std::string there;
  for (size_t i = 0; i < topics_.size(); ++i) {
    there += (there.empty() ? "" : ", ") + topics_[i].name;
    if (topics_[i].name == delayed.name) delayed.topic = static_cast<int>(i);
  }
  if (delayed.topic < 0) throw FormatError(who + ", which nobody makes; there are " + there);
  const ImageSpec& made = topics_[delayed.topic].spec;
  if (made != delayed.spec) {
    const bool records = made.pixel == Pixel::record && delayed.spec.pixel == Pixel::record;
    const auto type = [&](const ImageSpec& spec) { return records ? " of type " + std::to_string(spec.record) : ""; };
    throw FormatError(who + " as " + words(delayed.spec) + type(delayed.spec) + ", it is " + words(made) + type(made));
  }
  if (!delayed.image) delayed.image = std::make_unique<DelayedImage>(delayed.spec);
  return delayed.topic;
}

bool Driver::need(const std::string& topic) {
  for (const Topic& known : topics_) {
    if (known.name != topic) continue;
    stages_[static_cast<size_t>(known.stage)].need = Need::always;
    return true;
  }
  return false;
}

void Driver::need_all() { need_all_ = true; }

std::vector<Topic> Driver::published_topics() const {
  std::vector<Topic> all = topics_;
  all.push_back({"catalogue", record_spec<Catalogue>(), {}, -1});
  all.push_back({"health", record_spec<Health>(), {}, -1});
  all.push_back({"heartbeat", record_spec<Heartbeat>(), {}, -1});
  return all;
}

void Driver::choose_stages() noexcept {
  for (Stage& stage : stages_) {
    stage.runs = need_all_ || stage.need == Need::always;
    for (int output : stage.outputs) stage.runs = stage.runs || slots_[output].outlet->watched();
  }
  // Inputs are made further up, delayed ones anywhere: once more for each that begins to run by them.
  for (bool again = true; again;) {
    again = false;
    for (size_t i = stages_.size(); i-- > 0;) {
      if (!stages_[i].runs) continue;
      for (Handle input : stages_[i].inputs) {
        Stage& maker = stages_[topics_[input.topic].stage];
        again = again || (input.last >= 0 && !maker.runs);
        maker.runs = true;
      }
    }
  }
  for (size_t i = 0; i < stages_.size(); ++i) {
    if (!stages_[i].runs) continue;
    for (int output : stages_[i].outputs) slots_[output].publish_after = static_cast<int>(i);
    for (Handle input : stages_[i].inputs) {
      if (input.last < 0) slots_[input.topic].publish_after = static_cast<int>(i);
    }
  }
}

void Driver::begin_anew() noexcept {
  for (Stage& stage : stages_) stage.processor->begin_anew();
  for (Delayed& delayed : delayed_) {
    if (delayed.image) delayed.image->forget();
  }
}

Outcome Driver::step() noexcept {
  const int64_t start = monotonic_ns();
  step_starts_[steps_ % step_starts_.size()] = start;
  choose_stages();
  Outcome outcome = Outcome::valid;
  for (size_t i = 0; i < stages_.size(); ++i) {
    if (!stages_[i].runs) continue;
    const Outcome result = run(stages_[i]);
    if (result == Outcome::end) return Outcome::end;
    if (result == Outcome::invalid && stages_[i].begins()) outcome = Outcome::invalid;
    if (i == 0) ledger_.pair(result == Outcome::valid ? stages_[0].out[0]->ready_ns : 0);
    publish_after(static_cast<int>(i));
  }
  for (Delayed& delayed : delayed_) {
    if (delayed.image) delayed.image->end_step(outcome == Outcome::valid);
  }
  ++steps_;
  ++sequence_;
  if (outcome == Outcome::invalid) ++blind_steps_;
  step_total_ns_ += monotonic_ns() - start;
  return outcome;
}

Outcome Driver::run(Stage& stage) noexcept {
  const int64_t start = monotonic_ns();
  const Image* blind = nullptr;
  for (size_t i = 0; i < stage.inputs.size(); ++i) {
    const Handle input = stage.inputs[i];
    stage.in[i] = input.last < 0 ? slots_[input.topic].image : &delayed_[input.last].image->last();
    if (!blind && input.last < 0 && !input.even_blind && !stage.in[i]->valid()) blind = stage.in[i];
  }
  for (size_t i = 0; i < stage.outputs.size(); ++i) {
    const int topic = stage.outputs[i];
    Image& image = slots_[topic].outlet->loan();
    ++loans_;
    Image::make(&image, topics_[topic].spec);
    if (!stage.begins()) image.describe_like(*stage.in[0]);
    image.sequence = sequence_;
    image.epoch = epoch_;
    image.config_generation = config_generation_;
    slots_[topic].image = stage.out[i] = &image;
  }
  Outcome outcome = Outcome::invalid;
  if (blind) {
    for (Image* image : stage.out) image->set_blind(blind->reason);
  } else {
    outcome = stage.processor->process(stage.in, stage.out);
    if (outcome == Outcome::end) return outcome;
    if (outcome == Outcome::invalid)
      for (Image* image : stage.out) image->set_blind(image->valid() ? stage.out[0]->reason : image->reason);
  }
  const int64_t end = monotonic_ns();
  for (Image* image : stage.out) image->ready_ns = end;
  StageTiming& timing = stage.timing;
  ++timing.runs;
  if (outcome == Outcome::invalid) ++timing.invalid;
  timing.last_ns = end - start;
  timing.total_ns += end - start;
  timing.max_ns = std::max(timing.max_ns, timing.last_ns);
  return outcome;
}

void Driver::publish_after(int stage) noexcept {
  for (Slot& slot : slots_) {
    if (slot.publish_after == stage && slot.image) publish(slot);
  }
}

void Driver::publish(Slot& slot) noexcept {
  const auto topic = &slot - slots_.data();
  for (Delayed& delayed : delayed_) {
    if (delayed.topic == topic) delayed.image->keep(*slot.image);
  }
  if (viewer_) viewer_(topics_[static_cast<size_t>(topic)], *slot.image);
  if (topic == result_) ledger_.result(*slot.image, monotonic_ns());
  slot.image = nullptr;
  slot.outlet->publish();
}

}  // namespace vdisp
