// driver.cpp: the schedule is the order of add(); an image is published when its last reader has run, the map at once.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/driver.h"

#include <algorithm>
#include <cstring>
#include <iomanip>
#include <ostream>

#include "daemon/core/clock.h"

namespace vdisp {

struct Driver::Slot {
  std::unique_ptr<Outlet> outlet;
  Image* image = nullptr;  // loaned in this step, not yet published
  int publish_after = -1;  // the last stage of this step that reads it
};

struct Driver::Stage {
  std::unique_ptr<ImageProcessor> processor;
  std::vector<int> inputs, outputs;  // topics
  Need need;
  bool runs = false;  // in this step
  StageTiming timing;
  std::vector<const Image*> in;
  std::vector<Image*> out;
};

Driver::Driver(uint64_t epoch) : epoch_(epoch) {}
Driver::~Driver() = default;

std::string Driver::label(const Stage& stage) const {
  std::string text;
  for (int input : stage.inputs) {
    const ImageSpec& spec = topics_[input].spec;
    text += (text.empty() ? " of " : ", ") + ("'" + topics_[input].name + "'") + " (" + std::string(name(spec.pixel)) + " " +
            std::to_string(spec.width) + "x" + std::to_string(spec.height) + ")";
  }
  return text;
}

std::vector<Handle> Driver::add_set(std::vector<std::string> names, std::unique_ptr<ImageProcessor> processor, std::vector<Handle> inputs,
                                    Need need) {
  Stage stage;
  stage.need = need;
  std::vector<ImageSpec> in;
  for (Handle input : inputs) {
    if (input.topic < 0 || input.topic >= static_cast<int>(topics_.size()))
      throw FormatError("stage '" + names.at(0) + "': an input does not exist yet; stages are added after their inputs");
    stage.inputs.push_back(input.topic);
    in.push_back(topics_[input.topic].spec);
  }
  for (const std::string& topic : names) {
    const bool taken = std::any_of(topics_.begin(), topics_.end(), [&](const Topic& t) { return t.name == topic; });
    if (taken || topic == "catalogue" || topic == "heartbeat")
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
  for (size_t i = 0; i < topics_.size(); ++i) slots_[i].outlet = outlet(topics_[i].name, topics_[i].spec);
  catalogue_ = outlet("catalogue", record_spec<Catalogue>());
  heartbeat_ = outlet("heartbeat", record_spec<Heartbeat>());
}

void Driver::need_all() { need_all_ = true; }

std::vector<Topic> Driver::published_topics() const {
  std::vector<Topic> all = topics_;
  all.push_back({"catalogue", record_spec<Catalogue>(), {}, -1});
  all.push_back({"heartbeat", record_spec<Heartbeat>(), {}, -1});
  return all;
}

void Driver::choose_stages() noexcept {
  for (Stage& stage : stages_) {
    stage.runs = need_all_ || stage.need == Need::always;
    for (int output : stage.outputs) stage.runs = stage.runs || slots_[output].outlet->watched();
  }
  for (size_t i = stages_.size(); i-- > 0;) {
    if (!stages_[i].runs) continue;
    for (int input : stages_[i].inputs) stages_[topics_[input].stage].runs = true;
  }
  for (size_t i = 0; i < stages_.size(); ++i) {
    if (!stages_[i].runs) continue;
    for (int output : stages_[i].outputs) slots_[output].publish_after = static_cast<int>(i);
    for (int input : stages_[i].inputs) slots_[input].publish_after = static_cast<int>(i);
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
    if (result == Outcome::invalid && stages_[i].inputs.empty()) outcome = Outcome::invalid;
    publish_after(static_cast<int>(i));
  }
  ++steps_;
  if (outcome == Outcome::invalid) ++blind_steps_;
  step_total_ns_ += monotonic_ns() - start;
  return outcome;
}

Outcome Driver::run(Stage& stage) noexcept {
  const int64_t start = monotonic_ns();
  const Image* blind = nullptr;
  for (size_t i = 0; i < stage.inputs.size(); ++i) {
    stage.in[i] = slots_[stage.inputs[i]].image;
    if (!blind && !stage.in[i]->valid()) blind = stage.in[i];
  }
  for (size_t i = 0; i < stage.outputs.size(); ++i) {
    const int topic = stage.outputs[i];
    Image& image = slots_[topic].outlet->loan();
    Image::make(&image, topics_[topic].spec);
    if (!stage.in.empty()) image.describe_like(*stage.in[0]);
    image.sequence = steps_;
    image.epoch = epoch_;
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
  if (viewer_) viewer_(topics_[static_cast<size_t>(&slot - slots_.data())], *slot.image);
  slot.image = nullptr;
  slot.outlet->publish();
}

/// Median time from step to step over the last steps; 0 before the third.
int64_t Driver::period_ns() const noexcept {
  const size_t known = std::min<uint64_t>(steps_, step_starts_.size());
  if (known < 3) return 0;
  std::array<int64_t, 32> between;
  for (size_t i = 1; i < known; ++i)
    between[i - 1] = step_starts_[(steps_ - i) % step_starts_.size()] - step_starts_[(steps_ - i - 1) % step_starts_.size()];
  std::nth_element(between.begin(), between.begin() + static_cast<long>((known - 1) / 2), between.begin() + static_cast<long>(known - 1));
  return between[(known - 1) / 2];
}

void Driver::beat() noexcept {
  const int64_t now = monotonic_ns();
  const auto stamp = [&](Image& image, const ImageSpec& spec) {
    Image::make(&image, spec);
    image.sequence = steps_;
    image.epoch = epoch_;
    image.timestamp_ns = image.ready_ns = now;
  };
  const int64_t period = period_ns();
  if (now - last_beat_ns_ >= 150'000'000) {
    last_beat_ns_ = now;
    Image& image = heartbeat_->loan();
    stamp(image, record_spec<Heartbeat>());
    Heartbeat& heartbeat = make_record<Heartbeat>(image);
    heartbeat.steps = steps_;
    heartbeat.now_ns = now;
    heartbeat.period_ns = period;
    heartbeat_->publish();
  }
  if (now - last_catalogue_ns_ >= 1'000'000'000) {
    last_catalogue_ns_ = now;
    Image& image = catalogue_->loan();
    stamp(image, record_spec<Catalogue>());
    Catalogue& catalogue = make_record<Catalogue>(image);
    catalogue.period_ns = period;
    fill_catalogue(catalogue);
    catalogue_->publish();
  }
}

void Driver::fill_catalogue(Catalogue& catalogue) const noexcept {
  catalogue.steps = steps_;
  catalogue.blind_steps = blind_steps_;
  catalogue.step_mean_ns = steps_ ? step_total_ns_ / static_cast<int64_t>(steps_) : 0;
  catalogue.count = static_cast<uint32_t>(std::min<size_t>(topics_.size(), Catalogue::capacity));
  for (uint32_t i = 0; i < catalogue.count; ++i) {
    const Topic& topic = topics_[i];
    const StageTiming& timing = stages_[topic.stage].timing;
    CatalogueEntry& entry = catalogue.entries[i];
    topic.name.copy(entry.name, sizeof entry.name - 1);
    entry.spec = topic.spec;
    for (size_t p = 0; p < std::size(entry.parents); ++p)
      entry.parents[p] = p < topic.parents.size() ? static_cast<int16_t>(topic.parents[p].topic) : int16_t{-1};
    entry.stage = static_cast<uint32_t>(topic.stage);
    entry.watched = slots_[i].outlet->watched();
    entry.runs = timing.runs;
    entry.invalid = timing.invalid;
    entry.drops = slots_[i].outlet->drops();
    entry.last_ns = timing.last_ns;
    entry.mean_ns = timing.runs ? timing.total_ns / static_cast<int64_t>(timing.runs) : 0;
    entry.max_ns = timing.max_ns;
  }
}

StageTiming Driver::timing(Handle topic) const { return stages_.at(topics_.at(topic.topic).stage).timing; }

uint64_t Driver::drops() const {
  uint64_t sum = 0;
  for (const Slot& slot : slots_) sum += slot.outlet ? slot.outlet->drops() : 0;
  return sum;
}

void Driver::write_dot(std::ostream& out) const {
  out << "digraph vdisp {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans\"];\n";
  for (const Topic& topic : topics_) {
    const bool always = stages_[topic.stage].need == Need::always;
    out << "  \"" << topic.name << "\" [" << (always ? "style=bold" : "style=solid") << "];\n";
    for (Handle parent : topic.parents) {
      const Topic& from = topics_[parent.topic];
      out << "  \"" << from.name << "\" -> \"" << topic.name << "\" [label=\"" << name(from.spec.pixel) << " " << from.spec.width << "x"
          << from.spec.height << "\"];\n";
    }
  }
  out << "}\n";
}

void Driver::write_profile(std::ostream& out) const {
  std::vector<const Stage*> order;
  int64_t total = 0;
  for (const Stage& stage : stages_) {
    order.push_back(&stage);
    total += stage.timing.total_ns;
  }
  std::stable_sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->timing.total_ns > b->timing.total_ns; });
  const double seconds = static_cast<double>(step_total_ns_) * 1e-9;
  out << std::fixed << std::setprecision(2) << "profile: " << steps_ << " steps, " << blind_steps_ << " blind, "
      << (steps_ ? seconds * 1e3 / static_cast<double>(steps_) : 0.0) << " ms a step, "
      << (seconds > 0 ? static_cast<double>(steps_) / seconds : 0.0) << " Hz inside the tree, overhead "
      << (step_total_ns_ > 0 ? 100.0 * static_cast<double>(step_total_ns_ - total) / static_cast<double>(step_total_ns_) : 0.0) << " %\n";
  for (const Stage* stage : order) {
    const StageTiming& t = stage->timing;
    out << "  " << std::left << std::setw(24) << topics_[stage->outputs[0]].name << std::right;
    if (t.runs == 0) {
      out << "  disabled (nobody watched)\n";
      continue;
    }
    const double runs = static_cast<double>(t.runs);
    out << std::setw(7) << (total ? 100.0 * static_cast<double>(t.total_ns) / static_cast<double>(total) : 0.0) << " %" << std::setw(10)
        << static_cast<double>(t.total_ns) / runs * 1e-6 << " ms mean" << std::setw(10) << static_cast<double>(t.max_ns) * 1e-6 << " ms max"
        << std::setw(9) << t.runs << " runs" << std::setw(7) << t.invalid << " invalid\n";
  }
}

}  // namespace vdisp
