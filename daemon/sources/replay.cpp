// replay.cpp: pictures, times, numbers and inputs of a recording, in lock-step with the tree.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/replay.h"

#include <cmath>
#include <cstring>

#include "ipc/recording.h"

namespace vdisp {
namespace {

Recording read_recording(const std::string& folder) {
  try {
    return Recording(folder);
  } catch (const RecordingError& error) {
    throw SourceError(RecordingError::exit_code, "[image source] recording: " + std::string(error.what()));
  }
}

/// What is replayed is never driven by, and its times are still those of one clock.
uint32_t replayed(uint32_t flags) { return flags & flag_synthetic ? flags : flags | flag_synthetic | flag_replayed; }

class Replay final : public StereoSource {
 public:
  explicit Replay(const Config& config) : settings_(config.image_source), recording_(read_recording(settings_.recording)) {
    const std::string file = settings_.paramfile.empty() ? recording_.calibration().string() : settings_.paramfile;
    if (!file.empty()) calibration_ = read_calibration(file);
    if (recording_.steps().empty()) make_steps();
    if (recording_.pairs().empty())
      throw SourceError(66, "[image source] recording = " + settings_.recording + ": holds no whole pair; needed is one at least");
    const std::vector<RecordedStep>& steps = this->steps();
    const auto count = static_cast<int64_t>(steps.size());
    const int64_t lasts = steps.back().timestamp_ns - steps.front().timestamp_ns;
    span_ns_ = lasts + (count > 1 ? lasts / (count - 1) : 33'333'333);
  }

  std::vector<ImageSpec> open() override {
    const RecordingInfo& info = recording_.info();
    const auto words = [](int width, int height) { return std::to_string(width) + "x" + std::to_string(height); };
    const std::string found =
        "[image source] recording = " + settings_.recording + ": images are " + words(info.width, info.height) + ", needed ";
    const int width = settings_.width ? settings_.width : info.width, height = settings_.height ? settings_.height : info.height;
    if (width != info.width || height != info.height) throw SourceError(78, found + "by width and height is " + words(width, height));
    if (calibration_ && calibration_->width && (calibration_->width != info.width || calibration_->height != info.height))
      throw SourceError(78, found + "by the calibration is " + words(calibration_->width, calibration_->height));
    spec_ = {Pixel::gray8, 0, static_cast<uint16_t>(info.width), static_cast<uint16_t>(info.height)};
    return {spec_, spec_};
  }

  Outcome grab(std::span<Image* const> out) noexcept override;
  std::optional<Calibration> calibration() const override { return calibration_; }
  int64_t period_ns() const override { return settings_.rate > 0 ? std::llround(1e9 / settings_.rate) : 0; }
  std::pair<std::string, std::string> files() const override { return names_; }
  std::string_view fault() const noexcept override { return fault_; }
  const RecordedStep* recorded() const noexcept override { return recording_.steps().empty() ? nullptr : &step_; }
  std::optional<uint64_t> next_sequence() const noexcept override {
    const bool again = next_ >= steps().size();
    const RecordedStep& step = steps()[again ? 0 : next_];
    return step.sequence + (loops_ + again) * (steps().back().sequence - steps().front().sequence + 1);
  }

 private:
  const std::vector<RecordedStep>& steps() const { return recording_.steps().empty() ? made_ : recording_.steps(); }
  /// The recording tells of pairs alone.
  void make_steps() {
    for (const RecordedPair& pair : recording_.pairs()) {
      RecordedStep step;
      step.sequence = made_.size();
      step.timestamp_ns = pair.timestamp_ns;
      step.flags = recording_.info().synthetic ? uint32_t{flag_synthetic} : 0u;
      made_.push_back(step);
    }
  }
  void take_step() noexcept;
  bool read(std::span<Image* const> out) noexcept;

  const image_source_section settings_;
  Recording recording_;
  std::vector<RecordedStep> made_;
  std::optional<Calibration> calibration_;
  ImageSpec spec_;
  size_t next_ = 0, pair_ = 0;  // of steps() and of pairs
  uint64_t loops_ = 0;
  int64_t span_ns_ = 0;
  RecordedStep step_;  // the last one
  std::pair<std::string, std::string> names_;
  std::string fault_;
};

/// Times go on when the recording begins again, and its odometry begins anew.
void Replay::take_step() noexcept {
  step_ = steps()[next_++];
  const int64_t later = static_cast<int64_t>(loops_) * span_ns_;
  for (int64_t* time :
       {&step_.timestamp_ns, &step_.odometry.timestamp_ns, &step_.odometry.record.timestamp_ns, &step_.imu.timestamp_ns,
        &step_.imu.record.timestamp_ns, &step_.drive.timestamp_ns, &step_.drive.record.timestamp_ns, &step_.event.timestamp_ns})
    *time += later;
  for (Events::Entry& entry : step_.event.record.entries) entry.timestamp_ns += entry.label[0] ? later : 0;
  step_.odometry.record.frame += static_cast<uint32_t>(loops_) * (steps().back().odometry.record.frame + 1);
  step_.flags = replayed(step_.flags);
  for (uint32_t* flags : {&step_.odometry.flags, &step_.imu.flags, &step_.drive.flags, &step_.event.flags}) *flags = replayed(*flags);
}

bool Replay::read(std::span<Image* const> out) noexcept {
  try {
    const size_t pair = pair_++;
    names_ = {recording_.left(pair).string(), recording_.right(pair).string()};
    recording_.read(pair, *out[0], *out[1]);
    return true;
  } catch (const std::exception& error) {
    fault_ = error.what();
    return false;
  }
}

Outcome Replay::grab(std::span<Image* const> out) noexcept {
  fault_.clear();
  names_ = {};
  if (next_ >= steps().size()) {
    if (!settings_.loop) {
      if (recording_.cut_off() > 0)
        fault_ = "the recording " + settings_.recording + " was cut off: what it wrote last (" + std::to_string(recording_.cut_off()) +
                 ") is left out";
      return Outcome::end;
    }
    next_ = pair_ = 0;
    ++loops_;
  }
  take_step();
  Reason reason = step_.reason;
  if (reason == Reason::none && !read(out)) reason = Reason::bad_pair;
  for (Image* image : out) {
    image->timestamp_ns = step_.timestamp_ns;
    image->flags |= step_.flags;
    image->calibration_hash = calibration_ ? calibration_->hash : 0;
    if (reason == Reason::none) continue;
    image->set_blind(reason);
    for (int y = 0; y < spec_.height; ++y) std::memset(image->row<uint8_t>(y), 0, spec_.width);
  }
  return reason == Reason::none ? Outcome::valid : Outcome::invalid;
}

}  // namespace

std::unique_ptr<StereoSource> open_replay(const Config& config) { return std::make_unique<Replay>(config); }

}  // namespace vdisp
