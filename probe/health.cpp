// health.cpp: counts to words.
// SPDX-License-Identifier: Apache-2.0
#include "probe/health.h"

#include <nlohmann/json.hpp>

#include "probe/format.h"

namespace vdisp {
namespace {

using Json = nlohmann::ordered_json;

double ms(int64_t ns) { return static_cast<double>(ns) / 1e6; }
unsigned long long wide(uint64_t count) { return count; }

Json camera_json(const CameraView& view) {
  return {{"frames", view.frames}, {"incomplete", view.incomplete}, {"unpaired", view.unpaired}, {"refused", view.refused}};
}

/// "no_floor 3, no_frame 1"
std::string blind_words(const Health& health) {
  std::string text;
  for (uint32_t i = 0; i < Health::reasons; ++i) {
    if (health.blind[i] == 0) continue;
    const std::string why = i < static_cast<uint32_t>(Reason::count) ? std::string(name(static_cast<Reason>(i))) : std::to_string(i);
    text += (text.empty() ? "" : ", ") + why + " " + std::to_string(health.blind[i]);
  }
  return text;
}

}  // namespace

Json latency_json(const LatencyHistogram& latency) {
  const bool any = latency.count > 0;
  const auto time = [any](int64_t ns) { return any ? Json(ms(ns)) : Json(nullptr); };
  return {{"count", latency.count},
          {"mean_ms", any ? Json(ms(latency.sum_ns) / static_cast<double>(latency.count)) : Json(nullptr)},
          {"p50_ms", time(latency.percentile_ns(0.5))},
          {"p99_ms", time(latency.percentile_ns(0.99))},
          {"p999_ms", time(latency.percentile_ns(0.999))},
          {"max_ms", time(latency.max_ns)}};
}

std::string latency_words(const LatencyHistogram& latency) {
  if (latency.count == 0) return "no map yet";
  return format("p50 %.2f ms  p99 %.2f ms  p99.9 %.2f ms  max %.2f ms", ms(latency.percentile_ns(0.5)), ms(latency.percentile_ns(0.99)),
                ms(latency.percentile_ns(0.999)), ms(latency.max_ns));
}

Json health_json(const Health& health) {
  Json json{{"frames", health.frames}, {"no_pair", health.no_pair}, {"blind_frames", health.blind_frames}, {"blind", Json::object()}};
  for (uint32_t i = 1; i < static_cast<uint32_t>(Reason::count); ++i)
    if (health.blind[i] > 0) json["blind"][std::string(name(static_cast<Reason>(i)))] = health.blind[i];
  json["images"] = health.loans;
  json["drops"] = health.drops;
  json["map_drops"] = health.map_drops;
  json["deadline_ms"] = health.deadline_ns > 0 ? Json(ms(health.deadline_ns)) : Json(nullptr);
  json["deadline_of"] = health.deadline_of_exposure ? "exposure" : "pair";
  json["deadline_misses"] = health.deadline_misses;
  json["latency"] = latency_json(health.latency);
  json["cameras"] = nullptr;
  if (health.cameras)
    json["cameras"] = {{"pairs", health.camera.pairs},
                       {"skipped", health.camera.skipped},
                       {"left", camera_json(health.camera.view[0])},
                       {"right", camera_json(health.camera.view[1])}};
  for (int kind = 0; kind < 4; ++kind)
    json["inputs"][input_names[kind]] = {{"accepted", health.inputs_accepted[kind]}, {"refused", health.inputs_refused[kind]}};
  json["control"] = {{"connections_refused", health.connections_refused},
                     {"connections_closed", health.connections_closed},
                     {"requests_refused", health.requests_refused}};
  json["config_generation"] = health.config_generation;
  json["reloads"] = health.reloads;
  json["reloads_refused"] = health.reloads_refused;
  json["log_lines_lost"] = health.log_lines_lost;
  return json;
}

Json recorder_json(const RecorderStatus& recorder) {
  Json json{{"recording", recorder.recording != 0}, {"recorded", recorder.recorded}, {"flight", nullptr}};
  if (recorder.flight)
    json["flight"] = {{"held", recorder.held},     {"held_s", recorder.held_s}, {"written", recorder.written},
                      {"failed", recorder.failed}, {"lost", recorder.lost},     {"writing", recorder.writing != 0}};
  return json;
}

std::string recorder_words(const RecorderStatus& recorder) {
  if (recorder.lost + recorder.failed == 0) return {};
  return format("flight recorder: %llu steps lost, %llu of %llu folders failed\n", wide(recorder.lost), wide(recorder.failed),
                wide(recorder.asked));
}

std::string health_words(const Health& health) {
  std::string text = "map after " + latency_words(health.latency);
  if (health.deadline_ns > 0) text += format("; deadline %.1f ms, missed %llu times", ms(health.deadline_ns), wide(health.deadline_misses));
  text += "\n";
  if (health.blind_frames > 0)
    text += format("blind %llu of %llu frames: ", wide(health.blind_frames), wide(health.frames)) + blind_words(health) + "\n";
  if (health.drops > 0)
    text += format("dropped %llu of %llu images, %llu maps\n", wide(health.drops), wide(health.loans), wide(health.map_drops));
  if (const CameraStatus& camera = health.camera; health.cameras) {
    text +=
        format("pairs %llu, %llu given up for newer ones; frames incomplete %llu + %llu, unpaired %llu + %llu, refused %llu + %llu\n",
               wide(camera.pairs), wide(camera.skipped), wide(camera.view[0].incomplete), wide(camera.view[1].incomplete),
               wide(camera.view[0].unpaired), wide(camera.view[1].unpaired), wide(camera.view[0].refused), wide(camera.view[1].refused));
  }
  for (int kind = 0; kind < 4; ++kind)
    if (health.inputs_refused[kind] > 0)
      text += format("%s refused %llu of %llu\n", input_names[kind], wide(health.inputs_refused[kind]),
                     wide(health.inputs_accepted[kind] + health.inputs_refused[kind]));
  if (health.connections_refused + health.connections_closed + health.requests_refused > 0)
    text += format("control socket: %llu connections refused, %llu closed, %llu requests refused\n", wide(health.connections_refused),
                   wide(health.connections_closed), wide(health.requests_refused));
  if (health.reloads_refused > 0) text += format("vdisp.cfg not taken for its faults: %llu times\n", wide(health.reloads_refused));
  if (health.log_lines_lost > 0) text += format("log lines lost: %llu\n", wide(health.log_lines_lost));
  return text;
}

}  // namespace vdisp
