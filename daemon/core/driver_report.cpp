// driver_report.cpp: what the driver tells of itself: heartbeat, catalogue, health, graph and profile.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iomanip>
#include <ostream>

#include "daemon/core/clock.h"
#include "daemon/core/driver_parts.h"

namespace vdisp {

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
    Image& losses = health_->loan();
    stamp(losses, record_spec<Health>());
    Health& health = make_record<Health>(losses);
    fill_health(health);
    if (reporter_) reporter_(health, catalogue);
    health_->publish();
    catalogue_->publish();
  }
}

namespace {
int16_t number(Handle parent) { return parent.last < 0 ? static_cast<int16_t>(parent.topic) : delayed_parent(parent.topic); }
}  // namespace

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
      entry.parents[p] = p < topic.parents.size() ? number(topic.parents[p]) : int16_t{-1};
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

void Driver::fill_health(Health& health) const noexcept {
  health.since_ns = began_ns_;
  health.frames = steps_;
  health.no_pair = blind_steps_;
  health.loans = loans_;
  health.drops = drops();
  health.map_drops = result_ < 0 ? 0 : slots_[result_].outlet->drops();
  health.config_generation = config_generation_;
  ledger_.write(health);
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
      const ImageSpec& spec = spec_of(parent);
      out << "  \"" << name_of(parent) << "\" -> \"" << topic.name << "\" [label=\"" << name(spec.pixel) << " " << spec.width << "x"
          << spec.height << (parent.last < 0 ? "\"" : "\", style=dashed, constraint=false") << "];\n";
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
