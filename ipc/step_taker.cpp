// step_taker.cpp: pixels, headers and records, each from its topic.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/step_taker.h"

#include <cstring>

namespace vdisp {
namespace {

constexpr double order_holds_s = 0.3;  // an operator who lets go is forgotten: the drive stage's dead-man

/// Also of a blind image: its record tells what was refused, and what came last.
template <class Record>
bool take(const Image& image, RecordedInput<Record>& input) {
  const Record* record = record_of<Record>(image);
  if (!record) return false;
  input.reason = image.valid() ? Reason::none : image.reason;
  input.flags = image.flags;
  input.timestamp_ns = image.timestamp_ns;
  input.record = *record;
  return true;
}

}  // namespace

TakenStep::TakenStep(const ImageSpec& camera)
    : pixels_(std::make_unique_for_overwrite<uint8_t[]>(2 * static_cast<size_t>(camera.stride()) * camera.height)) {
  views.stride = camera.stride();
  views.left = pixels_.get();
  views.right = pixels_.get() + static_cast<size_t>(camera.stride()) * camera.height;
}

void StepTaker::begin(TakenStep& into) noexcept {
  taken_ = &into;
  taken_->views.label = Label::none;
  taken_->views.speed = taken_->views.turn_rate = std::nan("");
  seen_ = told_label_ = told_drive_ = false;
}

void StepTaker::see(std::string_view topic, const Image& image) noexcept {
  if (!taken_) return;
  RecordedStep& step = taken_->step;
  const bool left = topic == "camera/left", right = topic == "camera/right";
  if (left) {
    seen_ = true;
    step.sequence = image.sequence;
    step.timestamp_ns = image.timestamp_ns;
    step.reason = image.valid() ? Reason::none : image.reason;
    step.flags = image.flags;
    step.config_generation = image.config_generation;
  }
  if ((left || right) && image.valid() && image.spec != camera_) {
    step.reason = Reason::bad_pair;
  } else if ((left || right) && image.valid()) {
    const size_t bytes = static_cast<size_t>(camera_.stride()) * camera_.height;
    std::memcpy(taken_->pixels_.get() + (left ? 0 : bytes), image.row<uint8_t>(0), bytes);
  }
  if (left || right || image.spec.pixel != Pixel::record) return;
  if (take(image, step.odometry) || take(image, step.imu) || take(image, step.drive) || take(image, step.event) || !image.valid()) return;
  if (const Decision* truth = topic == "truth/steering" ? record_of<Decision>(image) : nullptr) {
    taken_->views.label = label_of(truth->steering);
    told_label_ = true;
  } else if (const DriveCommand* drive = topic == "drive" ? record_of<DriveCommand>(image) : nullptr) {
    taken_->views.speed = drive->speed;
    taken_->views.turn_rate = drive->turn_rate;
    told_drive_ = true;
  }
}

bool StepTaker::finish() noexcept {
  if (!taken_ || !seen_) return false;
  RecordedViews& views = taken_->views;
  const RecordedInput<DriveOrder>& order = taken_->step.drive;
  if (order.reason == Reason::none && order.record.age_s <= order_holds_s) {
    if (!told_label_) views.label = label_of(order.record.speed, order.record.turn_rate);
    if (!told_drive_) views.speed = order.record.speed, views.turn_rate = order.record.turn_rate;
  }
  taken_ = nullptr;
  return true;
}

}  // namespace vdisp
