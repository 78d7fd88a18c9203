// metrics.cpp: one line for each count, with its help.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/metrics.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "daemon/core/background.h"
#include "ipc/png.h"

namespace vdisp {
namespace {

/// Durations at which the latency is told, s.
constexpr double latency_steps[] = {0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.025, 0.03, 0.04,
                                    0.05,  0.075, 0.1,   0.15,  0.2,    0.3,  0.5,   1,    2,     5,    10};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}
std::string number(uint64_t value) { return std::to_string(value); }
double seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }

/// The lines of one metric stand together below its help.
class Text {
 public:
  void begin(const char* metric, const char* type, const char* help) {
    metric_ = std::string("vdisp_") + metric;
    text_ += "# HELP " + metric_ + " " + help + "\n# TYPE " + metric_ + " " + type + "\n";
  }
  template <class Number>
  void line(const std::string& labels, Number value, const char* suffix = "") {
    text_ += metric_ + suffix + (labels.empty() ? "" : "{" + labels + "}") + " " + number(value) + "\n";
  }
  template <class Number>
  void one(const char* metric, const char* type, const char* help, Number value) {
    begin(metric, type, help);
    line("", value);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_, metric_;
};

std::string label(const char* key, std::string_view value) { return std::string(key) + "=\"" + std::string(value) + "\""; }

void add_latency(Text& text, const LatencyHistogram& latency) {
  text.begin("latency_seconds", "histogram", "From the exposure (synthetic: from when the pair was there) to the map.");
  uint64_t below = 0;
  uint32_t bucket = 0;
  for (const double step : latency_steps) {
    for (; bucket + 1 < LatencyHistogram::buckets && seconds(LatencyHistogram::begin_ns(bucket + 1)) <= step; ++bucket)
      below += latency.counts[bucket];
    text.line(label("le", number(step)), below, "_bucket");
  }
  text.line(label("le", "+Inf"), latency.count, "_bucket");
  text.line("", seconds(latency.sum_ns), "_sum");
  text.line("", latency.count, "_count");
  text.begin("latency_quantile_seconds", "gauge", "The same since the start of the daemon; 1 is the longest.");
  for (const double share : {0.5, 0.99, 0.999, 1.0})
    text.line(label("quantile", number(share)), seconds(share < 1 ? latency.percentile_ns(share) : latency.max_ns));
}

void add_frames(Text& text, const Health& health, const Catalogue& catalogue) {
  text.one("frames_total", "counter", "Steps of the tree, blind ones counted.", health.frames);
  text.one("frames_without_pair_total", "counter", "Steps in which the source had no good pair.", health.no_pair);
  text.begin("blind_frames_total", "counter", "Frames whose map was blind, by reason.");
  for (uint32_t i = 1; i < static_cast<uint32_t>(Reason::count); ++i)
    text.line(label("reason", name(static_cast<Reason>(i))), health.blind[i]);
  text.one("period_seconds", "gauge", "Median time from step to step.", seconds(catalogue.period_ns));
  text.one("deadline_seconds", "gauge", "What a map may take; 0: no limit.", seconds(health.deadline_ns));
  text.one("deadline_misses_total", "counter", "Maps that took longer.", health.deadline_misses);
  add_latency(text, health.latency);
  text.one("images_total", "counter", "Images made.", health.loans);
}

void add_stages(Text& text, const Catalogue& catalogue) {
  const auto each = [&](const char* metric, const char* type, const char* help, auto value) {
    text.begin(metric, type, help);
    for (uint32_t i = 0; i < std::min(catalogue.count, Catalogue::capacity); ++i) {
      const CatalogueEntry& entry = catalogue.entries[i];
      text.line(label("stage", std::string_view(entry.name, strnlen(entry.name, sizeof entry.name))), value(entry));
    }
  };
  each("image_drops_total", "counter", "Images that nobody saw, as readers held every block.",
       [](const CatalogueEntry& entry) { return entry.drops; });
  each("stage_runs_total", "counter", "Runs of a stage.", [](const CatalogueEntry& entry) { return entry.runs; });
  each("stage_invalid_total", "counter", "Runs without a result.", [](const CatalogueEntry& entry) { return entry.invalid; });
  each("stage_mean_seconds", "gauge", "Mean time of a run.", [](const CatalogueEntry& entry) { return seconds(entry.mean_ns); });
  each("stage_max_seconds", "gauge", "Longest run.", [](const CatalogueEntry& entry) { return seconds(entry.max_ns); });
}

void add_cameras(Text& text, const CameraStatus& status) {
  text.one("pairs_total", "counter", "Complete pairs of the cameras.", status.pairs);
  text.one("pairs_skipped_total", "counter", "Pairs given up for a newer one.", status.skipped);
  const auto each = [&](const char* metric, const char* help, uint64_t CameraView::*count) {
    text.begin(metric, "counter", help);
    for (int side = 0; side < 2; ++side) text.line(label("camera", side == 0 ? "left" : "right"), status.view[side].*count);
  };
  each("camera_frames_total", "Whole frames.", &CameraView::frames);
  each("camera_incomplete_frames_total", "Frames with parts missing or damaged.", &CameraView::incomplete);
  each("camera_unpaired_frames_total", "Frames without their other half.", &CameraView::unpaired);
  each("camera_refused_frames_total", "Frames not newer than the one before.", &CameraView::refused);
}

void add_inputs(Text& text, const Health& health) {
  text.begin("inputs_total", "counter", "Messages of the control socket.");
  for (int kind = 0; kind < 4; ++kind) {
    text.line(label("kind", input_names[kind]) + "," + label("result", "accepted"), health.inputs_accepted[kind]);
    text.line(label("kind", input_names[kind]) + "," + label("result", "refused"), health.inputs_refused[kind]);
  }
  text.one("control_connections_refused_total", "counter", "Connections refused as all were in use.", health.connections_refused);
  text.one("control_connections_closed_total", "counter", "Connections closed for rubbish, or replies that were not read.",
           health.connections_closed);
  text.one("control_requests_refused_total", "counter", "Requests refused as too many waited.", health.requests_refused);
  text.one("config_generation", "gauge", "Changes of the configuration since the start.", health.config_generation);
  text.begin("reloads_total", "counter", "Times vdisp.cfg was read again.");
  text.line(label("result", "taken"), health.reloads);
  text.line(label("result", "refused"), health.reloads_refused);
}

void add_recorder(Text& text, const RecorderStatus& recorder) {
  text.begin("flight_recorder_folders_total", "counter", "Folders that the flight recorder was to write.");
  text.line(label("result", "written"), recorder.written);
  text.line(label("result", "failed"), recorder.failed);
  text.one("flight_recorder_steps_lost_total", "counter", "Steps it could not keep while older ones were being written.", recorder.lost);
}

}  // namespace

std::string metrics_text(const Health& health, const Catalogue& catalogue, const RecorderStatus& recorder, const std::string& instance,
                         bool up) {
  Text text;
  text.begin("up", "gauge", "1 while the daemon runs, 0 when it has ended in good order.");
  std::string escaped;
  for (const char letter : instance) escaped += letter == '"' || letter == '\\' ? std::string("\\") + letter : std::string(1, letter);
  text.line(label("name", escaped), uint64_t{up});
  add_frames(text, health, catalogue);
  add_stages(text, catalogue);
  if (health.cameras) add_cameras(text, health.camera);
  add_inputs(text, health);
  add_recorder(text, recorder);
  text.one("log_lines_lost_total", "counter", "Lines given up while standard error took none.", health.log_lines_lost);
  return text.take();
}

Metrics::Metrics(std::filesystem::path file, std::string instance, Tell tell)
    : file_(std::move(file)), instance_(std::move(instance)), tell_(std::move(tell)), counts_(std::make_unique<Counts>()) {
  write_file(file_, metrics_text(counts_->health, counts_->catalogue, counts_->recorder, instance_, true));
  sem_init(&news_, 0, 0);
  thread_ = std::thread([this] { work(); });
}

Metrics::~Metrics() {
  ending_ = true;
  sem_post(&news_);
  thread_.join();
  sem_destroy(&news_);
  write(false);
}

void Metrics::offer(const Health& health, const Catalogue& catalogue, const RecorderStatus& recorder) noexcept {
  if (full_.load(std::memory_order_acquire)) return;
  counts_->health = health;
  counts_->catalogue = catalogue;
  counts_->recorder = recorder;
  full_.store(true, std::memory_order_release);
  sem_post(&news_);
}

void Metrics::work() {
  begin_in_background("metrics");
  while (true) {
    while (sem_wait(&news_) != 0 && errno == EINTR) {
    }
    if (ending_) return;
    if (!full_.load(std::memory_order_acquire)) continue;
    write(true);
    full_.store(false, std::memory_order_release);
  }
}

void Metrics::write(bool up) {
  try {
    write_file(file_, metrics_text(counts_->health, counts_->catalogue, counts_->recorder, instance_, up));
    if (failed_) tell_("metrics: " + file_.string() + " is written again");
    failed_ = false;
  } catch (const WriteError& error) {
    if (!failed_) tell_(std::string("metrics: ") + error.what());
    failed_ = true;
  }
}

}  // namespace vdisp
