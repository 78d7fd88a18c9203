// camera_feed.cpp: opens with back-off, and again when frames end.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/camera_feed.h"

#include <algorithm>
#include <cmath>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

constexpr std::chrono::milliseconds first_pause{200}, longest_pause{500};
constexpr int wait_ms = 100;
constexpr int64_t silence_ns = 4'000'000'000;  // drivers that are told of a camera's end know it earlier

}  // namespace

CameraFeed::CameraFeed(std::unique_ptr<Camera> camera, int side, FrameTaker& taker, const std::atomic<bool>& exchanged, Settings settings)
    : camera_(std::move(camera)), side_(side), taker_(taker), exchanged_(exchanged), settings_(settings) {
  state_.view.exposure_us = state_.view.gain_db = std::nan("");
}

CameraFeed::~CameraFeed() { stop(); }

void CameraFeed::start() {
  thread_ = std::thread([this] { run(); });
}

void CameraFeed::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

CameraFeed::State CameraFeed::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

CameraView CameraFeed::view() const {
  const std::lock_guard lock(mutex_);
  return state_.view;
}

bool CameraFeed::add_problem(std::string& text) const {
  const std::lock_guard lock(mutex_);
  text += state_.problem;
  return !state_.problem.empty();
}

void CameraFeed::want(const ExposureSetting& setting) {
  const std::lock_guard lock(mutex_);
  wanted_ = setting;
}

void CameraFeed::trigger() noexcept {
  const std::unique_lock lock(device_, std::try_to_lock);
  if (lock && view().open) camera_->trigger();
}

CameraFeed::News CameraFeed::take_news() {
  const std::lock_guard lock(mutex_);
  const bool was_open = told_ == News::opened || told_ == News::back;
  if (state_.open) {
    if (was_open) return News::nothing;
    told_fault_.reset();
    return told_ = state_.view.opened == 1 ? News::opened : News::back;
  }
  if (!state_.tried || (!was_open && told_fault_ == state_.fault)) return News::nothing;
  told_fault_ = state_.fault;
  return told_ = was_open ? News::lost : News::waits;
}

void CameraFeed::keep_quiet_of_fault() {
  const std::lock_guard lock(mutex_);
  if (state_.tried && !state_.open) told_fault_ = state_.fault;
}

double CameraFeed::longest_exposure() const {
  const std::lock_guard lock(mutex_);
  return longest_exposure_;
}

double CameraFeed::highest_gain() const {
  const std::lock_guard lock(mutex_);
  return highest_gain_;
}

bool CameraFeed::pause(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, time, [&] { return stopping_; });
}

void CameraFeed::run() noexcept {
  std::chrono::milliseconds back_off = first_pause;
  while (pause(std::chrono::milliseconds(0))) {
    if (open()) {
      back_off = first_pause;
      deliver_frames();
      {
        const std::lock_guard lock(mutex_);
        state_.open = false;
        state_.view.open = 0;
      }
      const std::lock_guard device(device_);
      camera_->close();
    } else {
      back_off = std::min(2 * back_off, longest_pause);
    }
    taker_.changed(side_);
    pause(back_off);
  }
}

void CameraFeed::note_problem(CameraFault fault, std::string problem) noexcept {
  const std::lock_guard lock(mutex_);
  state_.tried = true;
  state_.fault = fault;
  state_.problem = std::move(problem);
}

bool CameraFeed::open() {
  const std::lock_guard device(device_);
  try {
    FrameFormat format = camera_->open();
    std::string stored = camera_->stored_calibration();
    std::string refused = taker_.refuse(side_, format);
    if (!refused.empty()) {
      camera_->close();
      note_problem(CameraFault::unsupported, camera_->name() + ": " + refused);
      return false;
    }
    clock_.reset();
    const std::lock_guard lock(mutex_);
    state_.tried = state_.open = true;
    state_.problem.clear();
    state_.format = std::move(format);
    state_.stored_calibration = std::move(stored);
    state_.view.open = 1;
    state_.view.exposure_us = state_.format.exposure_us;
    state_.view.gain_db = state_.format.gain_db;
    ++state_.view.opened;
    if (!wanted_) wanted_ = steered_;  // the other camera has it still
    longest_exposure_ = camera_->longest_exposure();
    highest_gain_ = camera_->highest_gain();
  } catch (const CameraError& error) {
    note_problem(error.fault, error.what());
    return false;
  } catch (const std::exception& error) {
    camera_->close();
    note_problem(CameraFault::failed, camera_->name() + ": " + error.what());
    return false;
  }
  taker_.changed(side_);
  return true;
}

void CameraFeed::deliver_frames() noexcept {
  int64_t heard_ns = monotonic_ns();
  const auto longest_silence = std::max(silence_ns, static_cast<int64_t>(5e9 * state_.format.period_s));
  while (pause(std::chrono::milliseconds(0))) {
    apply_exposure();
    RawFrame frame;
    const Delivery delivery = camera_->wait(wait_ms, frame);
    if (delivery == Delivery::nothing) {
      if (settings_.waits_for_signal || monotonic_ns() - heard_ns < longest_silence) continue;
      return note_problem(CameraFault::failed,
                          camera_->name() + ": no frame for " + std::to_string(longest_silence / 1'000'000'000) + " s; it is opened again");
    }
    if (delivery == Delivery::lost) return note_problem(CameraFault::absent, camera_->name() + ": " + std::string(camera_->problem()));
    heard_ns = monotonic_ns();
    if (delivery == Delivery::frame) {
      take(frame);
      camera_->release(frame);
    } else {
      const std::lock_guard lock(mutex_);
      ++state_.view.incomplete;
      state_.problem = camera_->name() + ": " + std::string(camera_->problem());
    }
  }
}

int64_t CameraFeed::when(const RawFrame& frame) noexcept {
  if (frame.exposed_ns >= 0) return frame.exposed_ns;
  return frame.camera_ns >= 0 ? clock_.when(frame.camera_ns, frame.arrival_ns - frame.delay_ns) : frame.arrival_ns - frame.delay_ns;
}

void CameraFeed::take(const RawFrame& frame) noexcept {
  int slot = -1;
  const std::vector<GrayView> views = taker_.borrow(slot);
  if (slot < 0) return;
  const bool good = pixels_.write(state_.format, frame, exchanged_ && settings_.both_views, views);
  {
    const std::lock_guard lock(mutex_);
    if (good) {
      ++state_.view.frames;
      state_.problem.clear();
    } else {
      ++state_.view.incomplete;
      state_.problem = camera_->name() + ": " + pixels_.problem();
    }
  }
  if (!good) return taker_.give_back(slot);
  taker_.deliver(side_, {when(frame), frame.count, slot});
}

void CameraFeed::apply_exposure() noexcept {
  std::optional<ExposureSetting> wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted.swap(wanted_);
    if (wanted) steered_ = wanted;
  }
  if (!wanted || !camera_->expose(wanted->exposure_us, wanted->gain_db)) return;
  const std::lock_guard lock(mutex_);
  state_.view.exposure_us = wanted->exposure_us;
  state_.view.gain_db = wanted->gain_db;
}

}  // namespace vdisp
