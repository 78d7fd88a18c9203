// frames.cpp: pairs are taken from the program's own sources, and rectified by its own stage, so that both sides see the same.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/frames.h"

#include <stdexcept>

#include "daemon/sources/source.h"
#include "daemon/stages/rectify.h"

namespace vdisp::bench {
namespace {

Set grab(StereoSource& source, const std::vector<ImageSpec>& specs) {
  Set set;
  std::vector<Image*> images;
  for (const ImageSpec& spec : specs) {
    set.push_back(std::make_shared<Picture>(spec));
    images.push_back(&set.back()->image());
  }
  if (source.grab(images) != Outcome::valid) throw std::runtime_error("the source gave no pair");
  return set;
}

Set rectify(const Set& raw, const std::optional<Calibration>& calibration, const Config& config) {
  Set views;
  Machine machine;
  for (Side side : {Side::left, Side::right}) {
    Rectify stage(side, calibration, machine, config);
    std::vector<std::unique_ptr<Picture>> out;
    if (run_stage(stage, {raw.at(static_cast<size_t>(side)).get()}, out) != Outcome::valid) throw std::runtime_error("no rectified view");
    views.push_back(std::move(out.at(0)));
  }
  return views;
}

void take(Frames& frames, const Config& config, int count) {
  const auto source = open_source(config);
  frames.calibration = source->calibration();
  const auto specs = source->open();
  for (int i = 0; i < count; ++i) {
    frames.raw.push_back(grab(*source, specs));
    frames.rectified.push_back(rectify(frames.raw.back(), frames.calibration, config));
  }
}

}  // namespace

Config config_of(const std::vector<std::string>& sets) {
  Config config;
  const ConfigReading reading = read_config("", sets, config);
  if (!reading.complaints.empty()) throw std::invalid_argument(reading.complaints.front().text);
  return config;
}

Frames simulated(int width, int height, int count) {
  Frames frames;
  for (int seed = 1; seed <= count; ++seed)
    take(frames,
         config_of({"image source.source=sim", "sim.scene=flat", "sim.rate=0", "sim.seed=" + std::to_string(seed),
                    "sim.width=" + std::to_string(width), "sim.height=" + std::to_string(height)}),
         1);
  return frames;
}

Frames recorded(const std::string& left, const std::string& right, const std::string& calibration, int count) {
  Frames frames;
  take(frames,
       config_of({"image source.source=files", "image source.left=" + left, "image source.right=" + right,
                  "image source.paramfile=" + calibration}),
       count);
  return frames;
}

}  // namespace vdisp::bench
