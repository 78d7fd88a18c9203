// recorder.cpp: what is told of a run beside its pairs.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/recorder.h"

#include <sstream>

#include "daemon/geometry/calibration_write.h"

namespace vdisp {

ImageSpec camera_spec(const Driver& driver) {
  for (const Topic& topic : driver.topics())
    if (topic.name == "camera/left") return topic.spec;
  return {};
}

RecordingInfo recording_info(const Config& config, const Driver& driver, uint64_t epoch) {
  const ImageSpec camera = camera_spec(driver);
  RecordingInfo info;
  info.program = "vdispd " VDISP_VERSION;
  info.source = config.image_source.source;
  info.synthetic = info.source == "sim" || info.source == "files";
  if (info.source == "sim") {
    info.world = config.sim.scene;
    info.seed = static_cast<uint64_t>(config.sim.seed);
  }
  info.epoch = epoch;
  info.width = camera.width;
  info.height = camera.height;
  return info;
}

std::vector<std::pair<std::string, std::string>> recording_texts(const Config& config, const std::optional<Calibration>& calibration) {
  std::vector<std::pair<std::string, std::string>> texts;
  if (calibration) texts.emplace_back("calibration.yml", calibration_texts(*calibration, CalibrationFormat::opencv)[0].content);
  std::ostringstream printed;
  print_config(printed, config);
  texts.emplace_back("vdisp.cfg", printed.str());
  return texts;
}

std::unique_ptr<Record> start_record(const std::string& folder, Driver& driver, const Config& config,
                                     const std::optional<Calibration>& calibration, uint64_t epoch) {
  driver.need("truth/steering");
  return std::make_unique<Record>(folder, recording_info(config, driver, epoch), recording_texts(config, calibration), camera_spec(driver));
}

}  // namespace vdisp
