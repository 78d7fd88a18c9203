// front_end.cpp: the stages from the raw pair to the depth map, each with a buffer for what it makes.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/front_end.h"

#include <sysexits.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/calibration.h"
#include "daemon/stages/census_disparity.h"
#include "daemon/stages/census_view.h"
#include "daemon/stages/depth_map.h"
#include "daemon/stages/rectify.h"
#include "daemon/stages/smoothed_view.h"
#include "daemon/tools/train/words.h"
#include "ipc/outlet.h"

namespace vdisp::train {
namespace {

Config config_of(const Recording& recording, const snow::Settings& settings) {
  const int width = recording.info().width, height = recording.info().height;
  const int scale = std::max(1, width / static_cast<int>(settings.width));
  if (width / scale != static_cast<int>(settings.width) || height / scale != static_cast<int>(settings.height))
    throw ToolError(EX_NOINPUT, recording.folder().string() + " is of " + std::to_string(width) + "x" + std::to_string(height) +
                                    " and cannot be made smaller by a whole number to " + std::to_string(settings.width) + "x" +
                                    std::to_string(settings.height) + "; give its size, or a part of it, with --size");
  Config config;
  // What else the recording was made with is of no concern, but a mosaic has to
  // be made grey.
  if (!recording.configuration().empty()) {
    Config theirs;
    const ConfigReading reading = read_config(recording.configuration(), {}, theirs);
    if (!reading.complaints.empty()) {
      std::ostringstream text;
      text << reading.complaints.front() << "; it would say whether the pictures are colour mosaics, take that line away or put it right";
      throw ToolError(EX_NOINPUT, text.str());
    }
    config.image_source.bayer = theirs.image_source.bayer;
  }
  config.census.scale = scale;
  config.census.smooth = settings.smooth == snow::Smooth::none ? "none" : settings.smooth == snow::Smooth::mean ? "mean" : "median";
  config.census.block = static_cast<int>(settings.block);
  config.census.width = static_cast<int>(settings.disparities);
  config.census.confidence = settings.confidence;
  return config;
}

std::optional<Calibration> calibration_of(const Recording& recording) {
  if (recording.calibration().empty()) return std::nullopt;
  return read_calibration(recording.calibration());
}

/// A stage with the image it writes.
struct Step {
  Step(std::unique_ptr<ImageProcessor> made, std::vector<const Image*> inputs) : stage(std::move(made)), in(std::move(inputs)) {
    std::vector<ImageSpec> specs;
    for (const Image* input : in) specs.push_back(input->spec);
    buffer.emplace(stage->check(specs).at(0));
    image = &buffer->loan();
  }
  Reason run() {
    const ImageSpec spec = image->spec;
    Image::make(image, spec)->describe_like(*in[0]);
    return stage->process(in, std::span(&image, 1)) == Outcome::valid ? Reason::none : image->reason;
  }
  std::unique_ptr<ImageProcessor> stage;
  std::vector<const Image*> in;
  std::optional<BufferOutlet> buffer;
  Image* image = nullptr;
};

}  // namespace

struct FrontEnd::Stages {
  Stages(const Recording& of, const snow::Settings& settings, Machine& machine)
      : recording(of), config(config_of(of, settings)), left(camera()), right(camera()) {
    const auto calibration = calibration_of(of);
    const auto add = [this](std::unique_ptr<ImageProcessor> stage, std::vector<const Image*> in) -> const Image* {
      return steps.emplace_back(std::move(stage), std::move(in)).image;
    };
    using std::make_unique;
    const Image* views[2] = {&left.loan(), &right.loan()};
    const Image* census[2];
    for (const Side side : {Side::left, Side::right}) {
      const Image*& view = views[static_cast<int>(side)];
      view = add(make_unique<Rectify>(side, calibration, machine, config), {view});
      view = add(make_unique<SmoothedView>(machine, config), {view});
      census[static_cast<int>(side)] = add(make_unique<CensusView>(machine), {view});
    }
    disparity = add(make_unique<CensusDisparity>(machine, config), {census[0], census[1], views[0]});
    depth_map = add(make_unique<DepthMap>(machine, config), {disparity});
  }
  ImageSpec camera() const {
    return {Pixel::gray8, 0, static_cast<uint16_t>(recording.info().width), static_cast<uint16_t>(recording.info().height)};
  }

  const Recording& recording;
  const Config config;
  BufferOutlet left, right;
  std::vector<Step> steps;
  const Image *disparity = nullptr, *depth_map = nullptr;
};

FrontEnd::FrontEnd(const Recording& recording, const snow::Settings& settings, Machine& machine)
    : stages_(std::make_unique<Stages>(recording, settings, machine)) {}
FrontEnd::~FrontEnd() = default;

Reason FrontEnd::run(size_t pair) {
  stages_->recording.read(pair, stages_->left.loan(), stages_->right.loan());
  for (Step& step : stages_->steps)
    if (const Reason reason = step.run(); reason != Reason::none) return reason;
  return Reason::none;
}

void FrontEnd::features(snow::Encoding encoding, std::span<uint8_t> pixels) const {
  const Stages& s = *stages_;
  BufferOutlet buffer(snow::feature_spec(encoding));
  Image& image = buffer.loan();
  snow::make_features(encoding, *s.disparity, *s.depth_map, s.config.census.width, image);
  for (int y = 0; y < image.spec.height; ++y) std::copy_n(image.row<uint8_t>(y), image.spec.width, pixels.data() + y * image.spec.width);
}

}  // namespace vdisp::train
