// recorder.cpp: what is told of a run beside its pairs, and who takes them.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/recorder.h"

#include <utility>

#include "daemon/core/background.h"
#include "daemon/core/clock.h"
#include "daemon/geometry/calibration_write.h"
#include "daemon/log/log.h"
#include "daemon/record/flight_place.h"

namespace vdisp {
namespace {

using Texts = std::vector<std::pair<std::string, std::string>>;

/// Never blind: it tells of the recorder, not of the frame.
class RecorderReport final : public ImageProcessor {
 public:
  explicit RecorderReport(const RecorderStatus& status) : status_(status) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<RecorderStatus>()}; }
  Outcome process(std::span<const Image* const>, std::span<Image* const> out) noexcept override {
    RecorderStatus& record = make_record<RecorderStatus>(*out[0]);
    const RecordHeader header = record.header;
    record = status_;
    record.header = header;
    return Outcome::valid;
  }

 private:
  const RecorderStatus& status_;
};

ImageSpec camera_spec(const Driver& driver) {
  for (const Topic& topic : driver.topics())
    if (topic.name == "camera/left") return topic.spec;
  return {};
}

RecordingInfo describe(const Config& config, const ImageSpec& camera, uint64_t epoch) {
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

/// What lies beside the pairs: the calibration, where there is one, and vdisp.cfg as it was understood.
Texts texts_of(std::string config, const std::optional<Calibration>& calibration) {
  Texts texts;
  if (calibration) texts.emplace_back("calibration.yml", calibration_texts(*calibration, CalibrationFormat::opencv)[0].content);
  texts.emplace_back("vdisp.cfg", std::move(config));
  return texts;
}

}  // namespace

void Recorder::add_report(Driver& driver) { driver.add("recorder", std::make_unique<RecorderReport>(status_)); }

void Recorder::start(const std::string& folder, Driver& driver, const Config& config, const std::optional<Calibration>& calibration,
                     uint64_t epoch, const std::function<std::string()>& config_text) {
  const ImageSpec camera = camera_spec(driver);
  if (!folder.empty()) {
    driver.need("truth/steering");
    record_ = std::make_unique<RecordThread>(folder, describe(config, camera, epoch), texts_of(config_text(), calibration), camera,
                                             [] { begin_in_background("recorder"); });
    folder_ = folder;
    status_.recording = 1;
  }
  if (config.recorder.seconds > 0) {
    flight_ = std::make_unique<FlightRecorder>(config, camera, describe(config, camera, epoch),
                                               [calibration, config_text] { return texts_of(config_text(), calibration); });
    flight_->tell(status_);
    if (const std::string trouble = trouble_with_flight_place(config.recorder.folder); !trouble.empty())
      log::warn("flight recorder: {}", trouble);
  }
}

void Recorder::see(const Topic& topic, const Image& image) noexcept {
  if (record_) record_->see(topic.name, image);
  if (flight_) flight_->see(topic.name, image);
}

void Recorder::finish_step() {
  if (record_) record_->finish_step(), ++status_.recorded;
  if (!flight_) return;
  flight_->finish_step(monotonic_ns());
  flight_->tell(status_);
}

void Recorder::ask_flight() noexcept {
  if (flight_) return flight_->ask(FlightCause::signal);
  log::warn("SIGUSR1: there is no flight recorder to write; [recorder] seconds is 0");
}

void Recorder::finish() {
  flight_.reset();
  if (!record_) return;
  record_->finish();
  log::info("{} pairs recorded in {}", record_->pairs(), folder_);
}

}  // namespace vdisp
