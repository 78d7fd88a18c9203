// stage_run.cpp: the tree as far as the floor.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/stage_run.h"

#include "daemon/core/driver.h"
#include "daemon/sources/source.h"
#include "daemon/stages/disparity.h"
#include "daemon/stages/plane_floor.h"
#include "daemon/stages/rectify.h"

namespace vdisp::calibrate {
namespace {

cv::Mat copy_of(const Image& image) {
  return cv::Mat(image.spec.height, image.spec.width, CV_8U, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()).clone();
}

void keep(const Topic& topic, const Image& image, StagedPair& pair) {
  if (topic.name == "camera/left") pair.camera[0] = copy_of(image);
  if (topic.name == "camera/right") pair.camera[1] = copy_of(image);
  if (topic.name == "left") pair.rectified[0] = copy_of(image);
  if (topic.name == "right") pair.rectified[1] = copy_of(image);
  if (topic.name == "floor_model") pair.floor = *record_of<FloorModel>(image);
}

/// Nobody sends gravity here: the floor is measured by the images alone.
class NoImu final : public ImageProcessor {
 public:
  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<Imu>()}; }
  Outcome process(std::span<const Image* const>, std::span<Image* const> out) noexcept override {
    out[0]->set_blind(Reason::no_imu);
    return Outcome::valid;
  }
};

}  // namespace

StageRun run_stages(std::unique_ptr<StereoSource> source, const Config& config, int most) {
  Machine machine(config.main.threads);
  Driver driver(0);
  StereoSource& stereo = *source;
  StageRun run;
  run.calibration = stereo.calibration();

  const auto camera = driver.add_set({"camera/left", "camera/right"}, std::move(source), {}, Need::always);
  const auto left = driver.add("left", std::make_unique<Rectify>(Side::left, run.calibration, machine, config), {camera[0]});
  const auto right = driver.add("right", std::make_unique<Rectify>(Side::right, run.calibration, machine, config), {camera[1]});
  const auto disparity = driver.add("disparity", std::make_unique<Disparity>(machine, config), {left, right});
  const auto imu = driver.add("in/imu", std::make_unique<NoImu>(), {}, Need::always);
  driver.add_set({"floor", "floor_model"}, std::make_unique<PlaneFloor>(machine, config), {disparity, left, even_blind(imu)}, Need::always);

  StagedPair pair;
  driver.set_viewer([&pair](const Topic& topic, const Image& image) { keep(topic, image, pair); });
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  driver.need_all();
  for (int i = 0; i < most; ++i) {
    pair = {};
    const uint64_t blind = driver.blind_steps();
    if (driver.step() == Outcome::end) break;
    if (driver.blind_steps() == blind && !pair.rectified[1].empty())
      run.pairs.push_back(pair);
    else
      ++run.bad;
  }
  return run;
}

}  // namespace vdisp::calibrate
